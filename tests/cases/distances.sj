sj 1
game distances "Who is nearest, and the least and the greatest over a domain" {
  size  far  : cells  = 9
  param lone : reward = 0.25
  episode 10
  kind tree  "T" { field fruit : { none, ripe } = ripe  glyph "t" with fruit = none }
  kind grass "."
  group ground = tree, grass
  map {
    "T..t"
    "...."
    ".T.."
  }
  agents 3 {
    acts turn_left, turn_right, forward, stay
    moves relative
    field way    : 0 .. far = 0
    field held   : reward = 0.5
    field friend : agent
    field known  : set of agent
  }
  phase start { each agent { send agent to grass } }
  schedule walk -> meet -> judge
  phase walk { move each agent }
  phase meet {
    each agent as a {
      set a.way = min(distance(a, tree) over tree where tree.fruit is ripe otherwise far)
      when a.way > 1 { set a.friend = a } otherwise { set a.friend = nobody }
      each agent as b where b is not a and distance(a, b) <= 1 { add b to a.known }
    }
    each tree where min(distance(agent, tree) over agent) == 0 { set tree.fruit = none }
  }
  phase judge {
    each agent as a {
      give max(b.held over agent as b in disc(2) of a where b is not a otherwise lone) to a
      give min(b.held / 2 over agent as b in a.known otherwise 0) to a
      give max(x.held over agent as x in a.friend otherwise 1) to a
      when count(agent as b on tree) > 1 { give min(c.held over agent as c on tree) to a }
      set a.held = max(distance(a, ground) over ground) / far * lone
    }
  }
  metrics {
    mean apart = max(max(distance(a, b) over agent as b) over agent as a)
    final nearest = min(agent.way over agent)
  }
}
