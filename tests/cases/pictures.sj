sj 1
game pictures "How cells and agents are drawn" {
  episode 10
  kind grass "."
  kind pool  "~" { field depth : 0 .. 3 = 1 }
  kind bush  "b" {
    field fruit : { none, ripe } = ripe
    field owner : agent
  }
  group land = grass, bush
  map { ".b~b." }
  agents 2 {
    acts stay, forward, pick_up
    moves relative
    field bag by { fresh, dry } : 0 .. 5 capped = 0
  }
  phase start { each agent { send agent to grass } }
  schedule walk -> take
  phase walk { move each agent }
  phase take {
    each agent as a on bush { set bush.owner = a }
    each agent as a where a chose pick_up {
      first bush in line(1) of a where bush.fruit is ripe { set bush.fruit = none  add 1 to a.bag[fresh] }
    }
  }
  look land                                                         as "#dfe8d0"
  look pool where pool.depth > 1 or pool.depth == 0                 as blue water
  look bush                                                         as tree green
  look bush where bush.fruit is ripe                                with red apple
  look bush where bush.owner is not nobody                          as grey tree with black
  look agent where agent.bag[fresh] > 0 and not sum(agent.bag) == 5 with apple
  variant night { look land as black }
}
