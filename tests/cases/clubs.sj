sj 1
game clubs "Sets of agents that belong to the world" {
  field voters : set of agent
  field teams  by { red, blue } : set of agent
  episode 10
  kind grass "."
  map { "...." }
  agents 3 {
    acts stay, vote, join
    field team : { red, blue } = red
  }
  phase start { each agent { send agent to grass } }
  schedule vote -> pay
  phase vote {
    each agent as a where a chose vote and not a in voters { add a to voters }
    each agent as a where a chose join { add a to teams[a.team] }
  }
  phase pay {
    when count(agent in voters) >= 2 {
      give 1 to voters
      pick 1 agent as lucky in voters { set lucky.team = blue }
      set voters = nobody
    }
    each agent as a where a in teams[red] { give 0.5 to teams[blue] }
  }
  observe { show voters as { has_voted where agent in voters, others_have where voters is not nobody, no_vote_yet } }
}
