# Where the carts come back was compared by a number that counts destinations, and a pass drops one before it.
sj 1
game found {
  episode 20
  kind pond "."
  kind rock "#" {
  }
  group ground = pond, rock

  map {
    ".....#"
    "#....#"
    "...#.."
  }
  agents 2 {
    acts stay
  }
  movers cart 3 "d" {
  }

  phase start {
    each agent {
      send agent to pond
    }
    each cart { send cart to pond }
  }
  schedule look_round -> tick -> trade -> walk_on -> settle -> let_cart_go
  phase look_round {
    each ground {
      first agent in disc(1) of ground {
        chance 0 {
          send agent to ground as other
        }
      }
    }
  }
  phase trade {
    pick 1 cart {
      send cart to pond after 2
    }
  }
  phase walk_on {
  }
  phase settle {
  }
  phase let_cart_go {
  }
}
