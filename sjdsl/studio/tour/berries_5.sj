sj 1
game berries "Berries" {
  size  players : count       = 2 in 1 .. 3
  param berry   : reward      = 1
  param regrow  : probability = 0.02 in 0 .. 0.5
  param cost    : reward      = -1
  param hurt    : reward      = -10
  param rest    : steps       = 25
  episode 100

  kind grass "."
  kind wall  "#" { blocks agents, beam }
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
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, zap
    moves relative
  }
  shape beam = line(3)

  phase start { each agent { send agent to gate facing east } }
  schedule tick -> grow -> walk -> shoot -> eat
  phase grow {
    each bush where bush.fruit is none {
      let near = count(bush as other in disc(1) of bush where other.fruit is ripe)
      chance case near { 0: 0, 1: regrow, 2..: 2 * regrow } { set bush.fruit = ripe }
    }
  }
  phase walk { move each agent }
  phase shoot {
    each agent as one where one chose zap {
      mark beam of one
      give cost to one
      first agent as hit in beam of one { give hurt to hit  send hit to gate after rest  tally zapped for one }
    }
  }
  phase eat {
    each agent on bush where bush.fruit is ripe {
      set bush.fruit = none
      give berry to agent
      tally eaten for agent
    }
  }

  metrics { event eaten  event zapped  mean ripe = count(bush where bush.fruit is ripe) }

  observe { window ahead 5, behind 1, left 3, right 3 }
  define ripe_bushes   = count(bush where bush.fruit is ripe)
  define shared(place) = count(bush as other in disc(1) of place where other.fruit is ripe)
  checks {
    once ripe_bushes == 0 always ripe_bushes == 0  # a stripped patch never comes back
    require cost < 0 and hurt < 0
    symmetric agents                               # no agent is treated differently from another
  }
  policy cooperator "eats only where two ripe neighbours remain" {
    seek bush where bush.fruit is ripe and shared(bush) > 1
  }
  policy defector "eats the nearest fruit" { seek bush where bush.fruit is ripe }
}
