sj 1
game pond {
  episode 20
  kind shore "."
  kind gate "g" { field fruit : { none, ripe } = ripe }
  kind water "~"
  map { "..g~" }
  agents 2 { acts stay, go  field home : cell of gate }
  phase start { each agent { send agent to shore } }
  schedule rest -> tick
  phase rest {
    each agent on gate { set agent.home = gate }
    each agent where agent chose go { send agent to agent.home }
    each agent as a where a chose stay { send a to a.home after 2 }
  }
}
