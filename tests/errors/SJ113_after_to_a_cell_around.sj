sj 1
game pond {
  episode 20
  kind shore "."
  kind gate "g"
  map { "..g.g" }
  agents 2 { acts stay, go }
  phase start { each agent { send agent to shore } }
  schedule rest -> tick
  phase rest {
    each agent as a on gate where a chose go { send a to gate after 2 otherwise stay }
    each shore as there { when any(agent on there) { give 1 to all } when any(agent as a where a on gate) { give 2 to all } }
    each agent as a { let n = a.index  when a on n { give 1 to a } }
  }
}
