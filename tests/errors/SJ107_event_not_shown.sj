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
  }
  phase start { each agent { send agent to shore } }
  schedule grow -> walk -> eat
  phase grow { each shore where nobody on shore { chance 0.1 { set shore.fruit = ripe } } }
  phase walk { move each agent }
  phase eat {
    each agent on shore where shore.fruit is ripe {
      set shore.fruit = none
      give 1 to agent
      tally eaten for agent
    }
  }
  observe { window ahead 2, behind 1, left 1, right 1  show event eated }
  metrics { event eaten }
}
