sj 1
game pond {
  episode 20
  kind shore   "."
  kind outside "~"
  map { "...~"
        "...~" }
  agents 2 {
    acts turn_left, turn_right, forward, stay
    moves relative
  }
  phase start { each agent { send agent to shore } }
  schedule walk
  phase walk { move each agent }
  observe { window ahead 2, behind 1, left 1, right 1 }
}
