# SYNTAX TEST "source.sj" "colours of a small game"
sj 1
# <-- storage.type.sj
#  ^ constant.numeric.sj
game orchard "A title # no comment" {  # a comment
# <---- storage.type.sj
#    ^^^^^^^ entity.name.type.sj
#            ^^^^^^^^^^^^^^^^^^^^^^ string.quoted.double.sj
#                                      ^^^^^^^^^^^ comment.line.number-sign.sj
  param apple : reward = 0.5
# ^^^^^ storage.type.sj
#       ^^^^^ entity.name.type.sj
#               ^^^^^^ support.type.sj
#                        ^^^ constant.numeric.sj
  kind tree "T" { field fruit : { none, ripe } = ripe }
#                 ^^^^^ storage.type.sj
#                       ^^^^^ variable.other.property.sj
  phase eat { each agent as eater on tree where tree.fruit is ripe { give apple to eater } }
# ^^^^^ storage.type.sj
#             ^^^^ keyword.control.sj
#                  ^^^^^ variable.language.sj
#                        ^^ keyword.operator.word.sj
#                           ^^^^^ variable.other.local.sj
#                                         ^^^^^ - comment
#                                                    ^^^^^ variable.other.property.sj
#                                                                    ^^^^ keyword.other.statement.sj
  checks { require count(tree) >= 1 }
#                  ^^^^^ support.function.sj
#                              ^^ keyword.operator.sj
  phase turn { send agent to tree facing north }
#                                        ^^^^^ constant.language.sj
}
