sj 1
game pasture "What was chosen is known in a step, not after it" {
  episode 10
  kind grass "."
  map { "..." }
  agents 2 { acts stay, zap  field calm : { no, yes } = yes }
  define zapping(who) = who chose zap
  phase start { each agent { send agent to grass } }
  schedule rest
  phase rest { each agent where zapping(agent) { set agent.calm = no } }
  observe { hide agent.calm when agent chose zap }
  metrics { mean zaps = count(agent where agent chose zap) }
  checks { always count(agent where zapping(agent)) <= 2 }
}
