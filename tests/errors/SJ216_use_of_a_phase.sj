sj 1
game pond {
  episode 20
  kind shore "." { field fruit : { none, ripe } = none }
  map { "...." }
  agents 2 { acts turn_left, forward, stay  moves relative }
  phase start { each agent { send agent to shore } }
  schedule walk -> bloom(count(shore where shore.fruit is ripe))
  phase walk { move each agent }
  phase bloom(many) { pick many shore { set shore.fruit = ripe } }
}
