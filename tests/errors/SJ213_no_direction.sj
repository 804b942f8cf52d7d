sj 1
game pond {
  episode 20
  kind shore "."  { field fruit : { none, ripe } = none }
  map { "...." }
  agents 2 { acts stay, shove  field friend : agent }
  phase start { each agent { send agent to shore } }
  schedule rest
  phase rest {
    each agent on shore where agent chose shove {
      send agent by 1 shore.fruit otherwise stay
      send agent by 1 toward step otherwise stay
      set shore.fruit = ripe
      set agent.friend = agent
    }
  }
}
