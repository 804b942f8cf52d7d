# A condition that is negated and the same for all that are counted became a negative number (without optimisation).
sj 1
game found {
  episode 20
  kind grass "."
  map { "..." }
  agents 2 { acts forward, turn_left, stay }
  phase start { each agent { send agent to grass } }
  schedule leave -> tick -> glance
  phase leave {
    each agent where agent chose stay { send agent to grass after 2 }
  }
  phase glance { each agent as one { tally seen by count(grass where not one.away) } }
  metrics {
    event seen
    final away = sum(count(grass where agent.away) over agent)
  }
}
