sj 1
game everyone "What all have is seen by all" {
  episode 10
  kind grass "."
  map { "..." }
  agents 3 {
    acts stay, take, leave
    field bag  by { raw, cut } : 0 .. 5 capped = 0
    field mood : { calm, wild } = calm
    timer tired
  }
  phase start { each agent { send agent to grass } }
  schedule act -> tick
  phase act {
    each agent as a where a chose take { add 1 to a.bag[cut]  set a.mood = wild  set a.tired = 3 }
    each agent as a where a chose leave and step > 2 { send a to grass after 2 otherwise stay }
  }
  observe {
    window ahead 1, behind 0, left 0, right 1
    show everyone.bag
    show everyone.mood as { like_me where everyone.mood is agent.mood, unlike_me }
    show everyone.tired as { rested where everyone.tired == 0, tired_more where everyone.tired > agent.tired, tired }
    show agent.mood
  }
}
