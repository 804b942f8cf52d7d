; Colours of the language `sj`. Each token has one capture, so it does not matter whether an editor takes the first or the last that fits.

(comment) @comment
(string) @string
(escape_sequence) @string.escape
(integer) @number
(decimal) @number.float

; ---- words of the language

[
  "about" "acts" "add" "after" "agents" "aim" "always" "as" "at" "avoiding" "away" "blocks" "by" "but" "capped" "checks" "choose" "cite"
  "conserved" "define" "draw" "drop" "episode" "episodes" "event" "expect" "extends" "facing" "field" "final" "focal" "for" "forbid" "from"
  "game" "give" "glyph" "group" "hide" "kind" "let" "look" "map" "mark" "mean" "metrics" "monotone" "move" "movers" "moves" "observe" "of"
  "once" "over" "param" "phase" "policy" "random" "remove" "require" "scenario" "schedule" "seek" "send" "set" "shape" "show" "size" "sj"
  "slots" "symmetric" "tally" "timer" "to" "toward" "variant" "where" "window" "with" "wraps" "along"
] @keyword
(end) @keyword
(ahead) @keyword
(all) @keyword
(all_but "all" @keyword)
["when" "chance" "otherwise" "case"] @keyword.conditional
["each" "pick" "first" "match"] @keyword.repeat
["and" "or" "not" "is" "in" "on" "chose"] @keyword.operator
(nobody) @constant.builtin
(count "count" @function.builtin)
(some "any" @function.builtin)
(every "all" @function.builtin)
(sum "sum" @function.builtin)

; ---- signs

["+" "-" "*" "/" "%" "<" "<=" ">" ">=" "==" "!=" "=" ".." "->"] @operator
["," ":" "."] @punctuation.delimiter
["{" "}" "(" ")" "[" "]"] @punctuation.bracket

; ---- names that are declared

(game name: (identifier) @type)
(kind name: (identifier) @type)
(group name: (identifier) @type)
(movers name: (identifier) @type)
(shape name: (identifier) @type)
(size name: (identifier) @constant)
(param name: (identifier) @constant)
(define name: (identifier) @function)
(phase name: (identifier) @function)
(policy name: (identifier) @function)
(scenario name: (identifier) @function)
(variant name: (identifier) @function)
(checks name: (identifier) @function)
(event name: (identifier) @variable)
(mean name: (identifier) @variable)
(final name: (identifier) @variable)
(field name: (identifier) @property)
(timer name: (identifier) @property)
(action name: (identifier) @constant)
(argument name: (identifier) @property)
(let name: (identifier) @variable)
(draw name: (identifier) @variable)
(bind name: (identifier) @variable)
(parameters (identifier) @variable.parameter)
(words (identifier) @constant)
(relabel name: (identifier) @constant)

; ---- names that are used

(about name: (identifier) @property)
(drop name: (identifier) @variable)
(unit (identifier) @type.builtin)
(unit "count" @type.builtin)
(by name: (identifier) @type)
(agent_type name: (identifier) @type)
(cell_type member: (identifier) @property kind: (identifier) @type)
(group kind: (identifier) @type)
(blocked (identifier) @type)
(glyph field: (identifier) @property)
(moves name: (identifier) @constant.builtin)
(turn phase: (identifier) @function)
(by_lot (identifier) @constant.builtin)
(facing heading: (identifier) @constant.builtin)
(stay (identifier) @constant.builtin)
(domain kind: (identifier) @type)
(on kind: (identifier) @type)
(on_expression kind: (identifier) @type)
(look kind: (identifier) @type)
(_ shape: (identifier) @type)
(_ action: (identifier) @constant)
(window side: (identifier) @constant.builtin)
(paint (identifier) @constant.builtin)
(badge (identifier) @constant.builtin)
(monotone value: (identifier) @function direction: (identifier) @constant.builtin argument: (identifier) @variable)
(symmetric (identifier) @type)
(player policy: (identifier) @function)
(slots policy: (identifier) @function)
(entry key: (identifier) @constant)
(arm key: (identifier) @constant)
(call function: (identifier) @function.call)
(extreme function: (identifier) @function.builtin)
(member name: (identifier) @property)

([
  (path name: (identifier) @variable.builtin)
  (held_cell name: (identifier) @variable.builtin)
  (all_but (identifier) @variable.builtin)
  (_ of: (identifier) @variable.builtin)
]
  (#match? @variable.builtin "^(agent|step)$"))
((path name: (identifier) @constant.builtin)
  (#match? @constant.builtin "^(yes|no|same|nowhere|north|east|south|west)$"))
([
  (path name: (identifier) @variable)
  (held_cell name: (identifier) @variable)
  (all_but (identifier) @variable)
  (_ of: (identifier) @variable)
]
  (#not-match? @variable "^(agent|step|yes|no|same|nowhere|north|east|south|west)$"))
