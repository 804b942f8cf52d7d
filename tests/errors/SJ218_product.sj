sj 1
game pond {
  param worth : count = 70000
  field stock : 0 .. 500000 capped = 0
  field low : 0 .. 9 = 3
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
      add 1 to stock
      tally eaten by worth * stock for agent
      when stock <= 1000 { tally eaten by worth * stock for agent }
      when 0 - worth * worth < 0 { tally eaten for agent }
      when step * 200000000 > 5 { tally eaten for agent }
      when 2000000000 + 200000000 > low { tally eaten for agent }
    }
  }
  observe { window ahead 2, behind 1, left 1, right 1 }
  metrics { event eaten }
}
