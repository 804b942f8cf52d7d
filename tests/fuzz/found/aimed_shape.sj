# A shape that a `let` nobody reads and a policy speak of was gone from the game, once nothing read the `let`.
sj 1
game found "Found" {
  episode 30
  kind grass "."
  map { "...." }
  agents 1 { acts forward, turn_left, stay }
  phase start { each agent { send agent to grass } }
  schedule look_round
  phase look_round {
    each grass { let unread = count(agent in diamond(2) of grass) }
    give 1 to all
  }
  policy shy { aim diamond(2) at grass choose stay }
}
