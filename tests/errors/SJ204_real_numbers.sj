sj 1
game pond {
  episode 20
  param rate : fraction = 0.5
  field pot : reward = 1
  kind shore "." { field fruit : { none, ripe } = none }
  kind water "~"
  map { "...~"
        "...~" }
  agents 2 {
    acts turn_left, turn_right, forward, stay
    moves relative
    field mood  : number in -1 .. 1 = 0
    field trust : fraction = 0.5
    field heat  : number in 0 .. 9 capped = 9.5
  }
  phase start { each agent { send agent to shore } }
  schedule grow -> walk -> eat
  phase grow { each shore where nobody on shore { chance 0.1 { set shore.fruit = ripe } } }
  phase walk { move each agent }
  phase eat {
    each agent on shore where shore.fruit is ripe {
      set shore.fruit = none
      set agent.mood = agent.mood * 1.01
      set agent.mood = pot
      set agent.trust = agent.trust * (1 - rate) + rate
      add 0.2 to agent.trust
      add pot to agent.heat
      when agent.trust <= 0.8 { add 0.2 to agent.trust }
      let more = agent.mood + 1
      set agent.mood = more - 1
      tally eaten for agent
    }
  }
  observe { window ahead 2, behind 1, left 1, right 1 }
  metrics { event eaten }
}
