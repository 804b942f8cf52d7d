sj 1
game meadow "Deer that flee, on a small meadow" {
  episode 9
  kind grass "." { field grown : { lush, bare } = lush }
  kind wall  "#" { blocks agents, deer }
  map { "....."
        "..#.." }
  agents 1 { acts turn_left, forward, stay, catch  moves relative }
  movers deer 2 "d" { field fear : 0 .. 3 capped = 0  timer rest }
  shape arm = line(1)
  phase start { each agent { send agent to grass facing north }  each deer { send deer to grass facing south } }
  schedule tick -> walk -> flee -> hold
  phase walk { move each agent }
  phase flee { move each deer where deer.rest == 0 away from agent where distance(agent, deer) == 1 }
  phase hold {
    each deer where deer.moved { add 1 to deer.fear }
    each agent as a where a chose catch { first deer in arm of a { give 1 to a  send deer to grass after 2  set deer.rest = 4 } }
  }
  observe { window ahead 1, behind 1, left 1, right 1  show deer.fear }
}
