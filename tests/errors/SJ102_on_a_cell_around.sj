sj 1
game pond {
  episode 20
  kind shore "."
  kind gate "g" { field team : { red, blue } = red }
  map { "..g.g" }
  agents 2 { acts stay, go }
  phase start { each agent { send agent to shore } }
  schedule rest
  phase rest {
    each gate { each agent on gate as there { set there.team = blue } }
    each agent on gate where agent chose go { send agent to gate where gate.team is blue otherwise stay }
  }
}
