sj 1
game camp "A camp with a field of every type" {
  param heat : steps  = 3
  param pay  : reward = { red: 1, blue: 2 }
  episode 50
  kind grass "."
  kind wall  "#" { blocks agents }
  kind gate  "P"
  kind tree  "T" {
    field fruit  : { none, ripe } = ripe
    glyph "t" with fruit = none
    field owner  : agent
    field takers : set of agent
    timer bare
  }
  map {
    "PPP..#"
    "..TT.."
    "......"
  }
  field pot by { red, blue } : 0 .. 99 capped = 0
  field mood : { calm, wild } = calm
  field rate : reward = 0.5
  timer night
  agents 3 {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, zap, leave
    moves relative
    field bag by { red, blue } : 0 .. 9 capped = 0
    field hue    : { red, blue } = red
    field friend : agent
    timer tired
    forbid zap when agent.tired > 0
  }
  shape ray = line(2)
  phase start { each agent { send agent to grass facing north } }
  schedule walk -> eat -> fire -> go -> tick -> dusk
  phase walk { move each agent }
  phase eat {
    each agent on tree where tree.fruit is ripe {
      set tree.fruit = none  set tree.owner = agent  set tree.bare = heat  add agent to tree.takers
      add 1 to agent.bag[agent.hue]  add 1 to pot[agent.hue]
      give pay[agent.hue] + rate to agent  tally eaten[agent.hue] for agent
    }
  }
  phase fire {
    each agent as zapper where zapper chose zap {
      mark ray of zapper
      set zapper.tired = 2
      each agent as hit in ray of zapper { send hit to gate after 2 facing south }
    }
  }
  phase go { each agent where agent chose leave and agent.friend is nobody { remove agent  tally left for agent } }
  phase dusk {
    when night == 0 and mood is wild { set night = 9  set mood = calm }
    each agent where agent chose zap { set agent.friend = nobody }
  }
  observe { show agent.bag  show agent.tired  hide tree.bare  hide tree.takers }
  metrics { event eaten by { red, blue }  event left  mean owned = count(tree where tree.owner is not nobody) }
}
