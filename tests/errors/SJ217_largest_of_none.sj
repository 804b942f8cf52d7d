sj 1
game pond {
  episode 20
  kind shore "." { field depth : 0 .. 3 = 0 }
  kind water "~"
  group ground = shore, water
  map { "...~"
        "...~" }
  agents 2 {
    acts turn_left, turn_right, forward, stay
    moves relative
    field bag : 0 .. 3 = 0
    field friends : set of agent
  }
  phase start { each agent { send agent to shore } }
  schedule walk -> compare
  phase walk { move each agent }
  phase compare {
    each agent {
      when max(shore.depth over shore where shore.depth > 1) > 1 { give 1 to agent }
      when max(shore.depth over shore) > 1 { give 1 to agent }
      when min(shore.depth over shore in disc(1) of agent) > 1 { give 1 to agent }
      when max(b.bag over agent as b in agent.friends) > 1 { give 1 to agent }
      when max(b.bag over agent as b) > 1 { give 1 to agent }
      when count(agent as x on shore) > 0 { when max(y.bag over agent as y on shore) > 1 { give 1 to agent } }
    }
    when min(agent.bag over agent) > 1 { give 1 to all }
    when step == 9 { pick 1 agent { remove agent } }
  }
  metrics {
    mean most = max(agent.bag over agent)
    mean some = max(agent.bag over agent on shore otherwise 0)
    mean wide = max(min(distance(shore, water) over water) over shore)
  }
}
