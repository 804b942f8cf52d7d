sj 1
game berries "Berries" {
  size  players : count  = 2 in 1 .. 3
  param berry   : reward = 1
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
  schedule walk -> eat
  phase walk { move each agent }
  phase eat {
    each agent on bush where bush.fruit is ripe {
      set bush.fruit = none
      give berry to agent
      tally eaten for agent
    }
  }

  metrics { event eaten  mean ripe = count(bush where bush.fruit is ripe) }
}
