sj 1
game herd {
  episode 20
  kind grass "." { field grown : { bare, lush } = lush }
  kind wall  "#" { blocks agents, deer }
  map { "...#"
        "...." }
  agents 2 {
    acts turn_left, turn_right, forward, stay, call
    moves relative
    field herd : set of agent
  }
  movers deer 2 "d" { field fed : 0 .. 9 = 0 }
  phase start { each agent { send agent to grass }  each deer { send deer to grass } }
  schedule walk -> roam -> act
  phase walk { move each agent at random }
  phase roam { move each deer at random }
  phase act { each deer where deer.fed < 9 { add 1 to deer.fed }  each agent as a { add a to a.herd } }
  
}
