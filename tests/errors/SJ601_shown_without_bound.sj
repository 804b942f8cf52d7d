sj 1
game pond {
  param nap : steps = 3
  episode 20
  kind shore "."
  map { "...." }
  agents 2 {
    acts forward, stay
    moves relative
    timer tired  forbid all when agent.tired > 0
  }
  phase start { each agent { send agent to shore } }
  schedule tick -> walk -> rest
  phase walk { move each agent }
  phase rest { each agent where agent.moved { set agent.tired = nap } }
  observe { show agent.tired }
}
