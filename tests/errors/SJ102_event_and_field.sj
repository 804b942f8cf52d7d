sj 1
game pond {
  episode 20
  kind shore "." { field fruit : { none, ripe } = none }
  kind water "~"
  map { "...~"
        "...~" }
  agents 2 {
    acts turn_left, turn_right, forward, stay
    moves relative
    field eaten : 0 .. 9 capped = 0
  }
  phase start { each agent { send agent to shore } }
  schedule grow -> walk -> eat
  phase grow { each shore where nobody on shore { chance 0.1 { set shore.fruit = ripe } } }
  phase walk { move each agent }
  phase eat {
    each agent on shore where shore.fruit is ripe {
      set shore.fruit = none
      give 1 to agent
      tally eaten for agent  add 1 to agent.eaten  tally shore
    }
  }
  observe { window ahead 2, behind 1, left 1, right 1  show event eaten  show event shore }
  metrics { event eaten  event shore }
}
