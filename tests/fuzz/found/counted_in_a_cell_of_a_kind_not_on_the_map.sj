# A field holds one cell, but of ponds the map has none: their number is 0, and no number from 0 to 1.
sj 1
game found {
  episode 20
  kind grass "."
  kind pond  "O"
  map { "..."  "..." }
  agents 3 { acts forward, turn_left, stay  field home : cell of pond }
  phase start { each agent { send agent to grass } }
  schedule walk -> count_them
  phase walk { move each agent }
  phase count_them { each agent { tally seen[count(pond in agent.home)] } }
  metrics { event seen by 0 .. 0 }
}
