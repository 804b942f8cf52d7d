sj 1
game pond {
  episode 20
  kind shore "." { field fruit : { none, ripe } = none }
  map { "...." }
  agents 2 { acts turn_left, forward, stay  moves relative }
  movers deer 2 "d"
  phase start { each agent { send agent to shore } }
  schedule walk -> flee
  phase walk { move each agent }
  phase flee { move each deer away from agent }
}
