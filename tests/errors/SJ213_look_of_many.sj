sj 1
game g {
  episode 3
  kind floor "."  kind gate "P"
  kind soil "a" { field fruit : { none, ripe } = none }
  map { "P.a" }
  agents 1 { acts stay }
  phase start { each agent { send agent to gate } }
  schedule rest
  phase rest { each agent as a { mark spot of a } }
  shape spot = line(1)
  observe {
    show gate as { soil }
  }
}
