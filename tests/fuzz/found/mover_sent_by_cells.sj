# A mover sent by cells had as many places as there are agents: the interpreter and the compiled game had it elsewhere.
sj 1
game base {
  episode 1

  kind tree "#" {
  }
  phase grow {
    match ground with agent {
      first ball as h_ in beam of agent {
        send h_ by 2 east otherwise stay
      }
    }
  }
  map {
    ".TT..."
    ".T...."
    ".T...T"
  }
  schedule grow -> let_ball_go

  kind rock "T" {
  }
  phase start {
    each agent { send agent to gate }
    each ball {
      send ball to gate
    }
  }

  phase let_ball_go {
  }
  kind gate "."

  shape beam { ".xx"  "..^"  "..." }

  movers ball 1 "d" {
  }
  group ground = gate, rock, tree
  agents 5 {
    acts stay
  }
}
