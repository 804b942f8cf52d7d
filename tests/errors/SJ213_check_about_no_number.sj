sj 1
game pasture "Checks about what is no number" {
  episode 10
  kind grass "."
  map { "..." }
  agents 2 { acts stay  field bag by { raw, cut } : 0 .. 5 capped = 0 }
  field pot by { raw, cut } : 0 .. 5 capped = 0
  define calm = count(agent where agent.bag[raw] > 0) == 0
  define held = sum(agent.bag[raw] over agent)
  phase start { each agent { send agent to grass } }
  schedule rest
  phase rest { each agent { add 1 to agent.bag[raw]  add 1 to pot[raw] } }
  observe { show agent.bag  show pot }
  checks {
    conserved pot
    monotone calm falling in held
  }
}
