sj 1
game pond {
  episode 20
  kind shore "." { field fruit : { none, ripe } = none }
  map { "...."
        "...." }
  agents {
    acts turn_left, turn_right, forward, stay, eat
    moves relative
    field bag : 0 .. 3 capped = 0
  }
  phase start { each agent { send agent to shore } }
  schedule grow -> walk -> eat
  phase grow { each shore where nobody on shore { chance 0.1 { set shore.fruit = ripe } } }
  phase walk { move each agent }
  phase eat {
    each agent on shore where agent chose eat and shore.fruit is ripe { set shore.fruit = none  add 1 to agent.bag }
  }
  observe { show agent.bag }
}
