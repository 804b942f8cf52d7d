sj 1
game pond {
  episode 20
  kind shore "." { field fruit : { none, ripe } = none }
  kind water "~"
  map { "...~"
        "...~" }
  agents 2 {
    acts turn_left, turn_right, forward, stay
    moves relative
  }
  phase start { each agent { send agent to shore } }
  schedule grow -> walk
  phase grow { each shore where nobody on shore { chance 0.1 { set shore.fruit = ripe } } }
  phase walk { move each agent }
  observe { window ahead 2, behind 1, left 1, right 1 }
  policy greedy { seek shore where shore.fruit is ripe }
  scenario visitor "one among greedy agents" { slots 0.5 focal  slots 1.5 policy greedy }
}
