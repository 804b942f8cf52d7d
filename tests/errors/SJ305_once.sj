sj 1
game pond {
  episode 20
  kind shore "." { field fruit : { none, ripe } = none }
  kind reed  "|" { blocks agents, beam }
  map { "...|"
        "...." }
  agents 2 {
    acts turn_left, turn_right, forward, stay
    moves relative
  }
  shape beam { ".x."
               "xxx" }
  phase start { each agent { send agent to shore } }
  schedule grow -> walk -> paint
  phase grow { each shore where nobody on shore { chance 0.1 { set shore.fruit = ripe } } }
  phase walk { move each agent }
  phase paint { each agent { mark beam of agent } }
}
