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
    each agent as a { each grass in disc(1) of a { set grass.taker = a by lot } }
    each grass where step > 3 { set grass.taker = nobody }
  }
}
