sj 1
game lots {
  episode 20
  kind grass "." { field taker : agent }
  map { "..." }
  agents 2 {
    acts stay, grab
    field votes by { yes, no } : 0 .. 9 = 0
  }
  phase start { each agent { send agent to grass } }
  schedule draw_lots
  phase draw_lots {
    each agent as a where a chose grab { each agent as b { set b.votes[yes] = a.index by lot } }
    each agent as a { each agent as b { set b.votes = a.votes by lot } }
  }
}
