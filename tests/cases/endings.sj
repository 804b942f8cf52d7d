sj 1
game endings "Branches, names for expressions, an end" {
  param length : steps  = 20
  param prize  : reward = 2
  episode length
  kind tree "T" { field fruit : { none, ripe } = ripe }
  kind path "_"
  map { "TT_" }
  agents 1 {
    acts forward, backward, stay
    moves compass
    field steps_taken : 0 .. 9 capped = 0
  }
  define left      = count(tree where tree.fruit is ripe)
  define rich(who) = who.steps_taken > 3 and left < 2
  phase start { each agent { send agent to path } }
  schedule walk -> eat -> close
  phase walk { move each agent }
  phase eat {
    each agent {
      when agent on tree { tally on_tree for agent }
      otherwise when rich(agent) { give prize * left / count(tree) to agent }
      otherwise { give min(prize, 1) to agent }
      when agent.moved { add 1 to agent.steps_taken }
    }
    each agent on tree where tree.fruit is ripe { set tree.fruit = none }
  }
  phase close { when left == 0 or step % 7 == 6 { end } }
  metrics { event on_tree  mean ripe = left }
}
