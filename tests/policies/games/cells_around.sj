sj 1
game cells_around "Domains of policies that ask who stands on the cell" {
  episode 40
  kind gate  "g"
  kind grass "."
  map { "g..g.."
        "......"
        "..g..." }
  agents 3 { acts forward, turn_left, turn_right, stay, jump  moves relative }
  movers deer 2 "d" { }
  phase start { each agent { send agent to grass }  each deer { send deer to gate } }
  schedule walk -> roam
  phase walk { move each agent }
  phase roam { move each deer at random }
  policy meeter { seek gate where any (deer on gate)  when agent on gate choose jump }
  policy alone { seek gate where not any (agent as other on gate where other is not agent) avoiding grass where any (deer on grass) }
}
