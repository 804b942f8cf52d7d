# Round a map, a shape of more cells than the map has held everybody who is away.
sj 1
game found {
  episode 20
  kind gate "."
  kind tree "#" { field hits : 0 .. 900 capped = 0 }
  map wraps { "..."  ".#."  "..."  "..#" }
  agents 4 { acts stay, forward, turn_left  field far : 0 .. 900 capped = 0 }
  phase start { each agent { send agent to gate }  each tree { add count(agent in square(2) of tree) to tree.hits } }
  schedule tick -> walk -> look_round -> go
  phase walk { move each agent }
  phase look_round {
    each tree { add count(agent in square(2) of tree) to tree.hits }
    each agent as a { add count(agent as b in square(2) of a) to a.far }
  }
  phase go { each agent where agent chose turn_left { send agent to gate after 2 } }
}
