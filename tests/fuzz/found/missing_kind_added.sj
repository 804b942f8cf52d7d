# An addition to one entry of a row of a group's cells, one of whose kinds is not on the map: JAX indexes no empty array.
sj 1
game found {
  episode 20
  kind tree  "." { field fruit by { low, high } : 0 .. 3 capped = 1 }
  kind grass "#" { field fruit by { low, high } : 0 .. 3 capped = 1 }
  group ground = tree, grass
  map { "..." }
  agents 2 { acts forward, turn_left, stay }
  phase start { each agent { send agent to tree } }
  schedule grow
  phase grow { pick 1 ground { add 1 to ground.fruit[highest(ground.fruit)] } }
}
