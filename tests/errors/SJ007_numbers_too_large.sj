sj 1
game pond {
  episode 20
  kind shore "." { field fruit : 0 .. 2000000000 = 0 }
  map { "...." }
  param most : count = 1500000000
  agents 2 { acts turn_left, forward, stay  moves relative }
  phase start { each agent { send agent to shore } }
  schedule walk
  phase walk { move each agent }
}
