sj 1
game counts "Agents see what a step counted" {
  episode 2 trials of 6
  kind grass "."
  kind den   "D"
  map { "...D." }
  agents 3 {
    acts stay, take, leave, spread
    field fans : set of agent = nobody
  }
  phase start { each agent { send agent to grass } }
  schedule act -> join -> tick
  phase act {
    each agent as a where a chose take { tally taken[raw] for a  tally taken[cut] by 200 for a }
    each agent as a where a chose leave { tally left_ for a  send a to den after 3 otherwise stay }
    each agent as a where a chose spread { tally spread_by by 2  tally liked for a.fans  set a.fans = nobody }
  }
  phase join {
    each agent as a { each agent as b where b chose take { when not a is b and not b in a.fans { add b to a.fans } } }
  }
  metrics { event taken by { raw, cut }  event left_  event spread_by  event liked }
  observe {
    window ahead 1, behind 0, left 0, right 1
    show event taken
    show event left_
    show event spread_by
    show event liked
  }
}
