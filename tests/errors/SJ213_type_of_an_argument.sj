sj 1
game market {
  episode 20
  kind stall "."
  map { "..." }
  agents 3 {
    acts stay, offer(apples : 0 .. 2, pears : 0 .. 2), vote(agent), say({ red, green }), wave, zap(reward), pile(0 .. 2 capped)
    field sold : 0 .. 9 capped = 0
    field heard : { none, red, green } = none
    field friend : agent
    forbid say(agent.sold) when agent.sold > 3
  }
  phase start { each agent { send agent to stall } }
  schedule trade
  phase trade {
    each agent where agent chose wave or agent chose offer or agent chose vote or agent chose say { set agent.heard = red }
    each agent where agent chose vote(agent.heard) { give 1 to agent }
    each agent where agent chose vote(nobody) { give 1 to agent }
    each agent where agent chose offer(0.5, 1) or agent chose offer(agent, 1) { give 1 to agent }
    each agent where agent.friend is not nobody { when agent.friend.vote is agent { give 1 to agent } }
  }
}
