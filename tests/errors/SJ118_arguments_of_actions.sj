sj 1
game market {
  episode 20
  kind stall "."
  map { "..." }
  agents 3 {
    acts stay, offer(apples : 0 .. 2, pears : 0 .. 2), vote(agent), say({ red, green }), wave, turn_left(agent)
    field sold : 0 .. 9 capped = 0
    field heard : { none, red, green } = none
    field friend : agent
    forbid vote(1, 2) when agent.sold > 1
    forbid wave(1) when agent.sold > 4
  }
  phase start { each agent { send agent to stall } }
  schedule trade
  phase trade {
    each agent where agent chose wave or agent chose offer or agent chose vote or agent chose say { set agent.heard = red }
    each agent where agent chose wave(1) { give 1 to agent }
    each agent where agent chose say(red, green) { give 2 to agent }
  }
  policy one { when agent.sold > 1 choose vote }
}
