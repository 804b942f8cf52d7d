sj 1
game market {
  episode 20
  kind stall "."
  map { "..." }
  agents 3 {
    acts stay, offer(apples : 0 .. 2, pears : 0 .. 2), vote(agent), say({ red, green }), wave
    field sold : 0 .. 9 capped = 0
    field heard : { none, red, green } = none
    field friend : agent
  }
  phase start { each agent { send agent to stall } }
  schedule trade
  phase trade {
    each agent where agent chose wave or agent chose offer or agent chose vote or agent chose say { set agent.heard = red }
    each agent {
      add agent.offer.apples to agent.sold
      when agent chose offer or agent.offer.pears > 1 { give 1 to agent }
      when agent chose offer and agent.offer.pears > 1 { give 2 to agent }
      when agent chose say(red) { add agent.offer.apples to agent.sold } otherwise { set agent.friend = agent.vote }
    }
    each agent as a where a chose vote { each agent as b where b.vote is a { give 3 to b } }
  }
}
