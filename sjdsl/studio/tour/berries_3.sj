sj 1
game berries "Berries" {
  size  players : count       = 2 in 1 .. 3
  param berry   : reward      = 1
  param regrow  : probability = 0.02 in 0 .. 0.5
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
  schedule grow -> walk -> eat
  phase grow {
    each bush where bush.fruit is none {
      let near = count(bush as other in disc(1) of bush where other.fruit is ripe)
      chance case near { 0: 0, 1: regrow, 2..: 2 * regrow } { set bush.fruit = ripe }
    }
  }
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
