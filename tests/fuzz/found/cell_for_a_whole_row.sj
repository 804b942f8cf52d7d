# A cell written to every entry of a row was taken for a row by the interpreter.
sj 1
game found "Found" {
  episode 20
  kind grass "."
  kind rock  "#"
  field night by agent : cell of grass
  field day   by agent : cell of grass
  map { "..."  "#.." }
  agents 2 { acts stay }
  phase start { each agent { send agent to grass } }
  schedule rest -> wake
  phase rest { each grass { set night = grass by lot } }
  phase wake { pick 1 grass { set day = grass } }
}
