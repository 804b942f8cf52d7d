sj 1
game herd {
  episode 20
  kind grass "." { field grown : { bare, lush } = lush }
  kind wall  "#" { blocks agents }
  map { "...#"
        "...." }
  agents 2 {
    acts turn_left, turn_right, forward, stay, call
    moves relative
    field herd : set of agent
  }
  movers wall 2 "d" { field fed : 0 .. 9 = 0 }
  phase start { each agent { send agent to grass }  each wall { send wall to grass } }
  schedule walk -> roam -> act
  phase walk { move each agent }
  phase roam { move each wall at random }
  phase act { each wall where wall.fed < 9 { add 1 to wall.fed }  each agent as a { add a to a.herd } }
  
}
