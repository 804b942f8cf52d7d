sj 1
game pond {
  episode 20
  kind shore "."
  map { "...." }
  agents 2 { acts up, west, rotate_left, noop, stay  moves compass }
  phase start { each agent { send agent to shore } }
  schedule walk
  phase walk { move each agent }
}
