sj 1
game pond {
  episode 20
  kind shore "." { field fruit : { none, ripe } = none }
  map { "...." }
  agents 2 { acts turn_left, forward, stay  moves relative }
  movers deer 2 "d"
  phase start { each agent { send agent to shore }  each deer { send deer to shore } }
  schedule walk -> graze
  phase walk { move each agent }
  phase graze { each deer on shore where shore.fruit is ripe { give 1 to deer } }
}
