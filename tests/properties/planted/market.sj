sj 1
game market "Who sells gets a coin from the buyer before him, if the buyer has one left" {
  episode 200
  kind ground "."
  kind field_ "f" { field crop : { no, yes } = yes }
  map { "f....f"
        "......"
        "f....f" }
  agents 4 {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, buy, sell
    moves relative
    field coins : 0 .. 20 capped = 1
    field goods : 0 .. 4 capped = 0
  }
  shape stall = line(1)
  phase start { each agent { send agent to ground } }
  schedule walk -> reap -> trade
  phase walk { move each agent }
  phase reap { each agent on field_ where field_.crop is yes and agent.goods < 2 { set field_.crop = no  add 1 to agent.goods } }
  phase trade {
    match agent as seller with first agent as buyer in stall of seller where seller chose sell and buyer chose buy and seller.goods > 0
        and buyer.coins > 0 and buyer.goods < 4 and seller.coins < 20 {
      add -1 to seller.goods  add 1 to buyer.goods
      add 1 to seller.coins  add -1 to buyer.coins
      give 3 to buyer  tally sold for seller
    }
  }
  metrics { event sold }
  checks { conserved sum(agent.coins over agent) }
  variant fault "a buyer with one coin can pay several sellers with it" {
    phase trade {
      each agent as seller where seller chose sell and seller.goods > 0 and seller.coins < 20 {
        first agent as buyer in stall of seller where buyer chose buy {
          when buyer.coins > 0 and buyer.goods < 4 {
            add -1 to seller.goods  add 1 to buyer.goods
            add 1 to seller.coins  add -1 to buyer.coins
            give 3 to buyer  tally sold for seller
          }
        }
      }
    }
  }
}
