sj 1
game away "Where somebody was who may have been away" {
  episode 5
  kind grass "."
  map { "..." }
  agents 2 { acts stay, leave  moves relative }
  phase start { each agent { send agent to grass } }
  schedule tick -> go
  phase go { each agent where agent chose leave { send agent to grass after 2 } }
  checks {
    always all(agent where before(agent.col) <= agent.col + 1)
    always before(all(agent where agent.col <= 2))
  }
}
