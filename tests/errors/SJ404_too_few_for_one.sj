sj 1
game pond {
  episode 20
  kind shore "." { field owner : 0 .. 3 = 0  glyph "1" with owner = 1 }
  map { "..11" }
  agents 3 { acts stay, swap }
  phase start { each agent { send agent to shore where shore.owner == agent.index } }
  schedule rest
  phase rest { each agent as a where a chose swap { send a to shore where shore.owner == a.index and shore.col > a.col otherwise stay } }
}
