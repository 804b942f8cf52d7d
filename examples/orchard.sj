sj 1
game orchard "Orchard" {
  size  players : count       = 3 in 2 .. 6
  param regrow  : probability = 0.05
  episode 200
  kind grass "."
  kind tree  "T" { field fruit : { none, ripe } = ripe }
  kind gate  "P"
  map { "TTTT....PP"  "TTTT....PP"  "TTTT....PP"  "TTTT....PP" }
  agents players { acts turn_left, turn_right, step_left, step_right, forward, backward, stay  moves relative }
  phase start { each agent { send agent to gate } }
  schedule grow -> walk -> eat
  phase walk { move each agent }
  define ripe_beside(cell) = count(tree as other in disc(1) of cell where other.fruit is ripe)
  # Fruit grows only beside ripe fruit: if all of it is eaten, none comes back.
  phase grow {
    each tree where tree.fruit is none {
      when ripe_beside(tree) > 0 {
        chance regrow { set tree.fruit = ripe }
      }
    }
  }
  phase eat {
    each agent on tree where tree.fruit is ripe {
      set tree.fruit = none
      give 1 to agent
    }
  }
  policy picker "picks the nearest fruit" { seek tree where tree.fruit is ripe }
}
