# A condition on a destination that is the same for all its cells gave one value instead of one for each cell.
sj 1
game found {
  param open : count = 0 in 0 .. 1
  episode 20
  kind grass "."
  kind rock  "T"
  map { "..T"  "..T" }
  agents 2 { acts forward, stay }
  phase start { each agent { send agent to grass } }
  schedule never -> perhaps
  phase never { each agent { send agent to rock where 1 > 1 otherwise stay } }
  phase perhaps { each agent where agent chose forward { send agent to rock where open > 0 otherwise stay } }
}
