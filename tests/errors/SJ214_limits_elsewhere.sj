# variants: crowd
sj 1
game pond {
  size  players : count = 2 in 2 .. 3
  param taste : reward = {
    raw: 1,
    ripe: 50
  } in 0 .. 5
  episode 20
  kind shore "." { field fruit : { raw, ripe } = raw }
  map { "...."
        "...." }
  agents players {
    acts turn_left, turn_right, forward, stay
    moves relative
  }
  phase start { each agent { send agent to shore } }
  schedule grow -> walk -> eat
  phase grow { each shore where nobody on shore { chance 0.1 { set shore.fruit = ripe } } }
  phase walk { move each agent }
  phase eat { each agent on shore where shore.fruit is ripe { give taste[ripe] to agent  set shore.fruit = raw } }
  variant crowd { set players = 4 }
}
