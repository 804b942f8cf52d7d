# Movers of which nothing is shown but where they are were painted alike, and `hide` asked about the first of them everywhere.
sj 1
game found "Found" {
  episode 5
  kind pond "."
  map { "..."  "..." }
  agents 2 { acts stay, forward }
  movers cart 3 "d"
  phase start {
    each agent { send agent to pond }
    each cart { send cart to pond }
  }
  schedule walk
  phase walk { move each agent }
  observe { hide cart when cart.index == 1 }
}
