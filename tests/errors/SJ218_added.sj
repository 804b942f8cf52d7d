sj 1
game pond {
  episode 20
  kind shore "." { field fruit : { none, ripe } = none }
  kind water "~"
  map { "...~"
        "...~" }
  field pot : 0 .. 1000000000 capped = 0
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
      add 1000000000 to pot
      tally eaten by 5
    }
  }
  observe { window ahead 2, behind 1, left 1, right 1 }
  metrics { event eaten }
}
