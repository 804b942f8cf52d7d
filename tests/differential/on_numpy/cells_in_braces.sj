sj 1
game cells_in_braces "Cells that are named one by one" {
  episode 30
  kind tree "T" { field fruit : { none, ripe } = ripe  field seen : 0 .. 20 capped = 0 }
  kind bush "b" { field fruit : { none, ripe } = none  field seen : 0 .. 20 capped = 0 }
  group plant = tree, bush
  map { "TbTb"
        "bTTb"
        "TbbT" }
  agents 3 {
    acts forward, turn_left, turn_right, stay, shake
    moves relative
    field home : cell of plant
  }
  phase start { each agent { send agent to plant } }
  schedule walk -> settle -> grow -> swap -> choose
  phase walk { move each agent }
  phase settle { each agent on plant where agent.home is nowhere { set agent.home = plant } }
  phase grow {
    match tree as t with bush as u in disc(1) of t where t.fruit is not u.fruit {
      each plant as one in { t, u } { set one.fruit = case one.seen % 2 == 0 { yes: ripe, no: none }  add 1 to one.seen }
    }
  }
  phase swap {
    each agent as a on plant as under_a where a chose shake {
      each plant as held in a.home {
        each plant as one in { under_a, held } { chance 0.5 { add 2 to one.seen } }
        give 0.5 * count(tree as one in { under_a, held }) to a
      }
    }
  }
  phase choose {
    each agent as a on plant as p {
      each plant as held in a.home { pick 1 bush as one in { p, held } { add 1 to one.seen  tally picked for a } }
    }
  }
  observe { show plant.fruit  show agent.home as { here where agent.home is not nowhere, nowhere_yet } }
  metrics { event picked }
}
