sj 1
game pond {
  size reach : cells = 2 in 1 .. 9
  episode 100
  kind shore "." { field fruit : { none, green, ripe } = none  field eggs : 0 .. 3 = 1 }
  kind tree "T" { field fruit : { none, ripe } = ripe  blocks agents when tree.fruit is ripe and tree.fruit is none }
  map { "..T"
        "..." }
  agents 2 { acts forward, stay, rest  moves relative  field bag : 0 .. 9 = 0  field far : 0 .. reach = 0  forbid rest when agent.bag in 10 .. 12 }
  movers duck 1 "d" { }
  define rich(who, n) = who.bag > n
  define torn(place) = place.fruit is ripe and not (place.fruit is ripe)
  phase start { each agent { send agent to shore }  each duck { send duck to shore } }
  schedule walk -> swim -> eat(none) -> eat(green) -> late
  phase walk { move each agent where agent.bag > 20 }
  phase swim { move each duck toward shore where shore.eggs > 3 avoiding agent where agent.bag < 0 }
  phase eat(state) {
    each shore where shore.fruit is state and shore.fruit is green { set shore.fruit = ripe }
    each shore where shore.fruit is state and shore.fruit is ripe { set shore.fruit = none }
    each agent on shore where agent chose rest and agent on tree { give 1 to agent }
  }
  phase late {
    when step > 100 { give 1 to all }
    pick 0 tree { give 2 to all }
    each agent as a where a.far > 8 or rich(a, 5) or rich(a, 20) { give 1 to a }
    each agent as a { each agent as b where b is not b { give 1 to a } }
    when 3 < count(shore where shore.fruit is not none and shore.fruit is not green and shore.fruit is not ripe) { give 1 to all }
    when any(tree where torn(tree)) or all(tree where tree.row >= 0) { give 1 to all }
  }
  look tree where tree.fruit is ripe and tree.fruit is none as red
  observe {
    window ahead 2, behind 1, left 1, right 1
    window ahead 3 when agent.bag < 0
    show agent.bag as { many where agent.bag > 5, more where agent.bag > 7, few }
    hide shore.fruit when step > 100
  }
  policy idle { seek shore where shore.fruit is none and shore.fruit is ripe  when step >= 100 choose rest }
  checks { always not any(agent where agent.bag > 9) }
}
