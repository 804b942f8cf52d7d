sj 1
game walking "Agents walk; a wall and a door that can be shut stop them" {
  episode 10
  kind grass "."
  kind wall  "#" { blocks agents }
  kind door  "D" { field state : { open, shut } = shut  glyph "/" with state = open  blocks agents when door.state is shut }
  map {
    ".#."
    ".D/"
  }
  agents 2 {
    acts turn_left, turn_right, forward, backward, stay
    moves relative
  }
  phase start { each agent { send agent to grass facing east } }
  schedule walk
  phase walk { move each agent }
}
