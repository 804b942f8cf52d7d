sj 1
game headings "Headings that are computed" {
  episode 12
  kind road "." {
    field way  : { north, east, south, west } = east
    field toll : { none, high } = none
    glyph "s" with way = south
    glyph "n" with way = north
  }
  kind gate "G"
  map wraps { ".s.nG"  "..s.."  "n..G." }
  field wind : { east, west } = west
  agents 3 {
    acts turn_left, turn_right, forward, stay, zap, leave
    moves relative
    field friend : agent
  }
  movers cart 2 "c"
  phase start { each agent { send agent to road facing same }  each cart { send cart to gate facing wind } }
  phase look_along at start { each agent on road { set agent.heading = road.way } }
  schedule tick -> walk -> turn -> push -> leave -> blow -> meet
  phase walk { move each agent }
  phase turn { each agent on road where agent chose stay and road.toll is none { set agent.heading = road.way  set road.toll = high } }
  phase push {
    match agent as a with first agent as hit in line(2) of a where a chose zap {
      send hit by 1 a.heading facing hit.heading otherwise stay
      send a by 1 toward hit facing hit.heading otherwise stay
    }
  }
  phase leave {
    each agent on road as here where agent chose leave {
      send agent to road as there where there.way is not here.way and nobody on there facing here.way otherwise stay
    }
    each cart where step % 3 == 1 {
      let back = case cart.heading { north: south, south: north, otherwise: wind }  send cart to gate after 2 facing back otherwise stay
    }
  }
  phase blow {
    when wind is west { set wind = east } otherwise { set wind = west }
    each agent where agent.index == 2 and agent chose zap { send agent to gate after 1 facing wind otherwise stay }
  }
  phase meet {
    each agent as a { each agent as b in line(1) of a where b.index < a.index { set a.friend = b by lot } }
    each agent where agent.friend is not nobody and agent chose turn_left { set agent.friend.heading = north }
    each cart as c where c.heading is wind { send c by 1 ahead facing south otherwise stay }
  }
  observe { window ahead 2, left 1, right 1  show cart.heading  hide other.heading when other.friend is agent or agent.heading is east }
  metrics { mean north_bound = count(agent where agent.heading is north) }
}
