sj 1
game capped_in_one_kind {
  episode 9
  kind bush "B" { field berries : 0 .. 5 capped = 2 }
  kind tree "T" { field berries : 0 .. 5 = 2 }
  kind grass "."
  group plant = bush, tree
  map { "BT..." }
  agents 2 { acts forward, stay  moves relative }
  phase start { each agent { send agent to grass } }
  schedule walk -> grow
  phase walk { move each agent }
  phase grow { each plant { add 4 to plant.berries } }
  observe { show plant.berries as { some where plant.berries > 0, none_left } }
}
