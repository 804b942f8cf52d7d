sj 1
game seen_cells "Labels that ask what cannot be painted into a cell" {
  episode 20
  kind gate "g" {
    field visits : 0 .. 9 capped = 0  field twin : cell of gate  field owner : agent  field visitors : set of agent
    field gold : reward  field notes by { aa, bb } : 0 .. 9 capped = 0  field mates by agent : 0 .. 3 capped = 0
    timer hot  field last : cell of place  field mood : { calm, wild } = calm
  }
  kind road "." { field gold : reward  field last : cell of place  field mood : { calm, wild } = calm }
  kind wall "#" { field mood : { calm, wild } = calm }
  group place = gate, road
  map { "g..g."
        "..#.g"
        "g...." }
  field path by 0 .. 2 : cell of place
  agents 3 { acts forward, turn_left, turn_right, stay, zap  moves relative  field home : cell of gate }
  phase start { each agent { send agent to place } }
  schedule tick -> walk -> rule -> look_back
  phase walk { move each agent }
  phase rule {
    each agent on gate where agent.home is nowhere { set agent.home = gate }
    each gate {
      pick 1 agent as a in square(1) of gate {
        set gate.owner = a  set gate.last = gate  add a to gate.visitors  set gate.twin = a.home  add 0.25 to gate.gold
        add 1 to gate.notes[bb]  add 1 to gate.mates[a]  set gate.hot = 3  add 1 to gate.visits
      }
    }
    each agent as a on road where a chose zap { mark line(2) of a }
    each road as r { pick 1 agent as a in square(1) of r { add 0.5 to r.gold  set r.last = r  set r.mood = wild } }
  }
  phase look_back {
    pick 1 agent on place as p where agent.moved { set path = shift(path, 1, p) } otherwise { set path = path }
  }
  observe {
    window ahead 2, behind 2, left 2, right 2
    show gate.visits as { home where agent.home is gate, foreign }
    show gate.twin as { mine where gate.twin is agent.home, far_off where gate.twin is not nowhere and gate.twin.visits > 1, unset }
    show place.last as { here where place.last is place, never }
    show gate.gold as { rich where gate.gold > 1, noted where gate.notes[bb] > 1 and gate.mates[agent] > 0, poor }
    show gate.visitors as { me where agent in gate.visitors, crowd where count(agent as b in gate.visitors) > 1, not_me }
    show gate.mood as { inside where count(road in disc(1) of gate) > 2 and count(agent as b in square(1) of gate) > 1, free }
    show road.gold as { way where path[1] is road, rich_way where road.gold > 2, plain }
    hide road.mood
    hide wall.mood
    hide marks on wall when wall.mood is calm
    hide marks on road when road.gold > 1
  }
}
