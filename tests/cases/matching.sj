sj 1
game matching "Pairs: whom each reaches first, and everyone with anyone near" {
  episode 10
  kind grass "."
  map { "...." }
  agents 3 {
    acts stay, ask
    field friend : agent
  }
  phase start { each agent { send agent to grass } }
  schedule greet -> meet
  phase greet {
    match agent as one with agent as two in square(1) of one { set one.friend = two  set two.friend = one }
  }
  phase meet {
    match agent as asker with first agent as answerer in line(2) of asker where asker chose ask {
      give 1 to asker
      give -1 to answerer
    }
    each agent where agent.friend is not nobody { each agent as other in agent.friend { tally greeted for other } }
  }
  metrics { event greeted }
}
