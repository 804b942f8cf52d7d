sj 1
game pond {
  episode 20
  kind shore "." { field fruit : { none, raw, ripe } = none }
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
    each agent on shore {
      set shore.fruit = none
      give case shore.fruit { none: 0, raw: 1 } to agent
      give case shore.fruit { none: 0, raw: 1, raw: 2, ripe: 3 } to agent
      give case shore.fruit { none: 0, 3: 1, otherwise: 2 } to agent
      give case shore.fruit { otherwise: 2, none: 0 } to agent
      give case shore.fruit { none: 0, raw: 1, ripe: 2, otherwise: 3 } to agent
      give case agent.row { 0: 0, 0..: 1 } to agent
      give case agent.row { raw: 0, otherwise: 1 } to agent
      tally eaten for agent
    }
  }
  observe { window ahead 2, behind 1, left 1, right 1 }
  metrics { event eaten }
}
