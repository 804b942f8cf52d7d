sj 1
game bearings "How far ahead and to the right something is, and what is computed for an observer" {
  size far : cells = 7
  episode 12
  kind gate  "g"
  kind grass "."
  kind pit   "o"
  group ground = grass, gate
  map {
    "g..o..g"
    "......."
    "...g..."
  }
  agents 3 {
    acts turn_left, turn_right, forward, stay
    moves relative
    field home  : cell of gate
    field ahead : -far .. far = 0
    field right : -far .. far = 0
  }
  movers deer 2 "d"
  define ahead_of_home(a) = case a.home is nowhere { yes: 0, no: steps_ahead(a, a.home) + far }
  define right_of_home(a) = case a.home is nowhere { yes: 0, no: steps_right(a, a.home) + far }
  define faces_home(a)    = a.home is not nowhere and steps_right(a, a.home) == 0
  define side(a)          = case a.index { 0: early, otherwise: late }
  field dummy : { early, late } = early
  phase start { each agent { send agent to ground }  each deer { send deer to ground } }
  schedule walk -> claim -> gaze -> roam -> fall
  phase walk { move each agent }
  phase claim {
    each agent where agent.home is nowhere { pick 1 gate { set agent.home = gate } }
  }
  phase gaze {
    each agent as a {
      set a.ahead = max(steps_ahead(a, deer) over deer otherwise -far)
      set a.right = min(steps_right(a, b) over agent as b)
      each agent as b where steps_ahead(a, b) > 0 and steps_right(a, b) == 0 { tally gazes for a }
    }
    each deer { when any (agent where steps_ahead(deer, agent) in 1 .. 2) { tally seen } }
  }
  phase roam { move each deer at random }
  phase fall { each agent on pit { remove agent } }
  observe {
    window ahead 1, behind 1, left 1, right 1
    show ahead_of_home(agent)
    show right_of_home(agent) when agent.home is not nowhere
    show faces_home(agent)
    show side(agent)
    show agent.ahead as { before where agent.ahead > 0, behind }
    show grass as { in_front where steps_ahead(agent, grass) > 0, grass }
  }
  metrics { event gazes  event seen }
  variant wraps { map wraps { "g..o..g"  "......."  "...g..."  "......." } }
}
