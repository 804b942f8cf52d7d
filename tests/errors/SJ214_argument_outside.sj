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
    each agent where agent chose offer(3, 0) { give 1 to agent }
    each agent where agent chose vote(3) or agent chose vote(4) { give 1 to agent }
  }
  policy one { when agent.sold > 1 choose offer(agent.sold, 1) }
  policy two { when agent.sold < 3 choose offer(agent.sold, 1) }
}
