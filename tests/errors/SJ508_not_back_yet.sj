sj 1
game pond {
  episode 20
  kind shore "." { field owner : agent }
  map { "...." }
  agents 2 { acts stay, swap }
  phase start { each agent { send agent to shore } }
  schedule rest -> tick
  phase rest {
    each agent where agent chose swap { send agent to shore where shore.col > agent.col after 2 otherwise stay }
    each agent where agent chose stay {
      send agent to shore as s where agent chose stay or s.owner is agent or count(agent as b in disc(1) of agent) > 0 after 1 otherwise stay
    }
  }
}
