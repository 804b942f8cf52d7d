sj 1
game berries "Berries" {
  size players : count = 2 in 1 .. 3
  episode 100

  kind grass "."
  kind wall  "#" { blocks agents }
  kind bush  "B" { field fruit : { none, ripe } = ripe  glyph "b" with fruit = none }
  kind gate  "G"
  map {
    "#######"
    "#G.BB.#"
    "#..BB.#"
    "#G...G#"
    "#######"
  }

  agents players {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay
    moves relative
  }

  phase start { each agent { send agent to gate facing east } }
  schedule walk
  phase walk { move each agent }
}
