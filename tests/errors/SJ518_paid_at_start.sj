sj 1
game paid "Rewards, counts and ends before the first step" {
  episode 3
  kind grass "."
  map { "..." }
  agents 2 { acts stay, forward, wave  moves relative }
  phase start { each agent { send agent to grass  give 1 to agent } }
  phase greet at start {
    each agent where agent chose wave { mark line(1) of agent }
    each agent on grass { tally arrived for agent }
    when count(agent) > 1 { end }
  }
  phase stroll at start { move each agent }
  schedule next
  phase next { move each agent }
  metrics { event arrived }
}
