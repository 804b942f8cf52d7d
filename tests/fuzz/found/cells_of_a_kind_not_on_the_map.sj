# What a rule asks about the cell of a pair was looked up in a table without entries, as the map has no pond.
sj 1
game found {
  episode 20
  kind grass "."
  kind pond  "O" { field depth : 0 .. 3 = 1 }
  map { "..."  "..." }
  agents 3 { acts forward, stay }
  phase start { each agent { send agent to grass } }
  schedule meet
  phase meet {
    match agent as a with agent as b on pond {
      when count(pond as other in disc(1) of pond) > 1 and nobody on pond { give 1 to a }
    }
    match pond as a with agent as b { when nobody on a { give 0.5 * pond_like(a) to b } }
    each agent as a { first pond in line(2) of a { give 1.5 * pond.depth to a } }
    pick 2 pond { give 1.5 * pond.depth to all } otherwise { give 0.25 to all }
    give 1.0 * sum(pond.depth over pond) to all
  }
  define pond_like(x) = x.depth + count(pond in disc(2) of x)
}
