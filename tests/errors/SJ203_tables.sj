sj 1
game pond {
  episode 20
  param meal : reward = { none: 0, raw: 1, none: 2, ripe: 2 }
  param share : reward = { none: 1, raw: 2, ripe: 3, low: 4 }
  param pay : reward = { none: { low: 1, high: 2 }, raw: { left: 1, right: 2 }, ripe: { low: 1, high: 2 } }
  kind shore "." { field fruit : { none, raw, ripe } = none  field level : { low, high } = low  field side : { left, right } = left }
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
  observe { window ahead 2, behind 1, left 1, right 1 }
  metrics { event eaten }
}
