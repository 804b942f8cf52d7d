sj 1
game pond {
  episode 20
  kind shore "."
  kind gate "g" { field team : { red, blue } = red }
  map { "..g.g" }
  agents 2 { acts stay, go, leave  field home : cell of gate }
  phase start { each agent { send agent to shore } }
  schedule rest -> tick
  phase rest {
    each agent on gate { set agent.home = gate }
    each agent where agent chose go { pick 1 gate in agent.home { send agent to gate } }
    each agent where agent chose leave { pick 1 gate as there { send agent to there } }
  }
}
