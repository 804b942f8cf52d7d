sj 1
game pond "What other cases are built on" {
  episode 20
  param meal : reward = 1
  param growth : probability = 0.1
  kind shore "." { field fruit : { none, ripe } = none }
  map { "...." }
  agents 2 { acts turn_left, turn_right, forward, stay  moves relative }
  phase start { each agent { send agent to shore } }
  schedule grow -> walk -> eat
  define gift(who) = case who.index { 0: meal, otherwise: 2 * meal }
  phase grow { each shore where nobody on shore { chance growth { set shore.fruit = ripe } } }
  phase walk { move each agent }
  phase eat { each agent on shore where shore.fruit is ripe { set shore.fruit = none  give gift(agent) to agent } }
  observe { window ahead 2, behind 1, left 1, right 1 }
  variant rich {
    set meal = 3
    set growth = 0.2
    phase eat { each agent on shore where shore.fruit is ripe { set shore.fruit = none  give gift(agent) to agent  give meal to all } }
    map { ".." }
    define gift(who) = 2 * meal
    observe { window ahead 4 }
  }
}
