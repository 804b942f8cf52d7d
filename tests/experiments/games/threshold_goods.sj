sj 1
game threshold_goods "Agents who never move pay, or not; if enough of them have paid, everybody has the good" {
  size  players : count  = 4 in 2 .. 8
  param needed  : count  = 2 in 1 .. 8
  param good    : reward = 4 in 0 .. 20
  param cost    : reward = 1 in 0 .. 20
  episode 2

  kind floor "."
  map { "........" }

  agents players {
    acts stay, keep
    field deed : { pay, keep_it } = pay
  }

  phase start { each agent { send agent to floor } }
  schedule decide -> share
  phase decide { each agent { when agent chose keep { set agent.deed = keep_it } otherwise { set agent.deed = pay } } }
  phase share {
    each agent where count(agent as other where other.deed is pay) >= needed { give good to agent }
    each agent where agent.deed is pay { give -cost to agent }
  }

  observe { window ahead 0, behind 0, left 0, right 0 }
}
