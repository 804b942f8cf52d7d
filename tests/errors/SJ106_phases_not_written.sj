sj 1
game pond "A schedule without its phases, and a phase without its schedule" {
  episode 20
  kind shore "." { field fruit : { none, ripe } = none }
  map { "...." }
  agents 2 { acts turn_left, turn_right, forward, stay  moves relative }
  phase start { each agent { send agent to shore } }
  schedule walk -> grow -> harvest -> sell -> settle
  phase walk { move each agent }
  phase grew(amount) { each agent on shore { set shore.fruit = ripe  give amount to agent } }
}
