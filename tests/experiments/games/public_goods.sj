sj 1
game public_goods "Agents who never move give 1, or not; what is given is multiplied and shared" {
  size  players    : count  = 3 in 2 .. 8
  param multiplier : reward = 2 in 0 .. 20
  param ranked     : reward = 0 in 0 .. 1
  episode 2

  kind floor "."
  map { "........" }

  agents players {
    acts stay, keep
    field deed : { give_one, keep_it } = give_one
  }

  phase start { each agent { send agent to floor } }
  schedule decide -> share
  phase decide { each agent { when agent chose keep { set agent.deed = keep_it } otherwise { set agent.deed = give_one } } }
  phase share {
    each agent { give multiplier * count(agent as other where other.deed is give_one) / players to agent }
    each agent where agent.deed is give_one { give ranked * agent.index - 1 to agent  tally given for agent }
    each agent where agent.deed is keep_it { give -100 * ranked * agent.index to agent }
  }

  observe { window ahead 0, behind 0, left 0, right 0 }
  metrics { event given }
}
