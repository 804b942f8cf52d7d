sj 1
game pond {
  episode 20
  kind shore "." { field fruit : { none, ripe } = none }
  map { "...." }
  agents 2 { acts turn_left, forward, stay  moves relative }
  size worth : count = { none: 1, ripe: 2 }
  phase start { each agent { send agent to shore } }
  schedule walk
  phase walk { move each agent }
}
