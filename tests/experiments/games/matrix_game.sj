sj 1
game matrix_game "Two who never move are paid by a matrix" {
  param payoff : reward = { cooperate: { cooperate: 3, defect: 0 }, defect: { cooperate: 5, defect: 1 } }
  episode 4

  kind floor "."
  map { ".." }

  agents 2 {
    acts stay, betray
    field deed : { cooperate, defect } = cooperate
  }

  phase start { each agent { send agent to floor } }
  schedule decide -> pay
  phase decide { each agent { when agent chose betray { set agent.deed = defect } otherwise { set agent.deed = cooperate } } }
  phase pay { each agent as one { each agent as other_one where other_one is not one { give payoff[one.deed][other_one.deed] to one } } }

  observe { window ahead 0, behind 0, left 0, right 0 }

  variant stag_hunt { set payoff = { cooperate: { cooperate: 4, defect: 0 }, defect: { cooperate: 3, defect: 1 } } }
  variant chicken { set payoff = { cooperate: { cooperate: 3, defect: 1 }, defect: { cooperate: 4, defect: 0 } } }
  variant harmony { set payoff = { cooperate: { cooperate: 4, defect: 2 }, defect: { cooperate: 3, defect: 1 } } }
  variant deadlock { set payoff = { cooperate: { cooperate: 1, defect: 0 }, defect: { cooperate: 3, defect: 2 } } }
}
