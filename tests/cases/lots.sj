sj 1
game lots "Drawn by lot: two statements draw together, rows and entries of rows" {
  episode 8
  kind grass "." { field owner : agent }
  kind tree  "T" { field taker : agent  field paid by { red, blue } : 0 .. 9 = 0 }
  map { "..T"
        "T.." }
  agents 3 {
    acts turn_left, forward, stay, grab, ask
    field trust by agent : 0 .. 3 = 1
    field likes by { red, blue } : 0 .. 9 = 0
  }
  field leader : agent
  field prices by { red, blue } : 0 .. 9 = 2
  phase start { each agent { send agent to grass } }
  schedule walk -> draw_lots
  phase walk { move each agent }
  phase draw_lots {
    each agent as a where a chose grab {
      each tree in disc(1) of a { set tree.taker = a by lot  set tree.paid[red] = a.index by lot }
      set leader = a by lot
      each agent as b in square(1) of a { set b.trust[a] = 3 by lot  set b.likes = a.likes by lot }
    }
    each agent as a where a chose ask {
      each tree in square(1) of a { set tree.taker = nobody by lot  set tree.paid[blue] = 7 by lot  set tree.paid[red] = 9 by lot }
      set leader = a by lot
      each agent as b in square(2) of a { set b.likes = 4 by lot }
      set prices[red] = a.index by lot
    }
    each agent as a where a chose forward { set prices[blue] = 1 by lot }
  }
}
