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
    forbid vote(who), wave when who is agent
  }
  phase start { each agent { send agent to stall } }
  schedule trade
  phase trade {
    each agent where agent chose wave or agent chose offer or agent chose vote or agent chose say { set agent.heard = red }
    each agent where agent chose offer { when agent.offer > 1 { give 1 to agent } }
  }
  observe { hide agent.heard when agent.vote is agent }
}
