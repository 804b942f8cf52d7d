sj 1
game wrapping "A map whose edges are joined" {
  size  far  : cells  = 4
  param prey : reward = 2
  episode 20
  kind grass "."
  kind tree  "T" { field fruit : { none, ripe } = ripe  glyph "t" with fruit = none }
  kind wall  "#" { blocks agents, ray }
  group ground = grass, tree
  map wraps {
    "..T."
    ".#.."
    "t..."
    "...."
  }
  shape ray = line(5)
  shape fork = fan(3, 2)
  agents 3 {
    acts turn_left, turn_right, forward, step_right, stay, zap, pull
    moves relative
    field way    : 0 .. far = 0
    field nearby : 0 .. 99 capped = 0
    blocks fork
  }
  movers deer 2 "d"
  phase start { each agent { send agent to ground }  each deer { send deer to ground } }
  schedule walk -> watch -> pull -> push -> flee -> roam
  phase walk { move each agent }
  phase watch {
    each agent as a {
      set a.way = min(distance(a, tree) over tree)
      set a.nearby = min(count(tree in disc(3) of a) + count(grass in ray of a), 99)
    }
    each agent as a where a chose zap {
      mark ray of a
      each agent as b in fork of a { give 1 to b }
      first deer in ray of a { give prey to a  tally caught for a }
    }
    each tree where count(tree as other in square(2) of tree where other.fruit is ripe) > 0 { set tree.fruit = ripe }
  }
  phase pull { match agent as a with agent as b in ray of a where a chose pull { send b by 2 toward a otherwise stay } }
  phase push { match agent as a with agent as b in ray of a where a chose zap { send b by 3 a.heading otherwise stay } }
  phase flee { move each deer where deer.index == 0 away from agent avoiding tree }
  phase roam { move each deer where deer.index == 1 ahead }
  observe {
    window ahead 5, behind 1, left 2, right 2
    show tree.fruit when distance(agent, tree) <= 2
    show other.index when distance(agent, other) <= 3
  }
  metrics { event caught  mean apart = max(max(distance(a, b) over agent as b) over agent as a) }
  policy hunter { aim ray at deer avoiding tree choose zap }
  policy walker { seek tree where tree.fruit is ripe }
}
