sj 1
game pond {
  episode 20
  param meal : reward = 1
  param few : steps = 1000
  param many : steps = 3000
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
      let share = ramp(step, few, many)
      give meal * share to agent
      tally eaten for agent
    }
  }
  observe { window ahead 2, behind 1, left 1, right 1 }
  metrics { event eaten }
  checks { require few < many }
}
