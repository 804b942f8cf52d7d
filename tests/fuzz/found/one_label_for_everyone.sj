# One label for a field of every agent: a plain number was read entry by entry.
sj 1
game base {
  kind gate "."
  map { "...." }
  agents 3 {
    acts stay
    field debt : agent
  }
  observe { show everyone.debt as { near_by } }
  phase start { each agent as c_ { send c_ to gate } }
  schedule trade
  phase trade { }
  episode 1
}
