sj 1
game m "What is shown of a kind has a mistake; another kind looks like it" {
  episode 10
  kind gate  "." { field left : { ripe, blue } = blue }
  kind grass "#"
  map {
    "..#"
  }
  agents 2 { acts stay }
  schedule rest
  phase start { each agent { send agent to gate } }
  phase rest { }
  observe {
    show gate as { outside where ruined, near_by }
    show grass as { gate where agent.heading is north, near_by }
  }
}
