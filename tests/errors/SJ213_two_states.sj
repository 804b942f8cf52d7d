sj 1
game states "`before` where there is one state, and `all` of nothing" {
  episode 5
  kind grass "."
  map { "..." }
  agents 2 { acts stay  field bag : 0 .. 9 capped = 0 }
  phase start { each agent { send agent to grass } }
  schedule eat
  phase eat { each agent where before(agent.bag) < 3 { add 1 to agent.bag } }
  checks {
    always before(before(step)) < step
    conserved before(step)
    always all(agent)
  }
}
