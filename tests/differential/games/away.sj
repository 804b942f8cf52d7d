sj 1
game away "Being sent, away, removed; choosing" {
  size  players : count       = 4 in 2 .. 6
  param delay   : steps       = 2 in 0 .. 9
  param keep    : probability = 0.7
  size  reach   : cells       = 9
  episode 50
  kind floor "." { field heat : 0 .. 3 = 0 }
  kind den   "d" { field full : { no_one, some } = no_one }
  kind pen   "P"
  kind wall  "#" { blocks agents, zapline }
  map { "Pd..#.dP"
        "..#....."
        "P.....dP" }
  agents players {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, zap, leave
    moves relative
    field lives : 0 .. 5 = 5
  }
  shape zapline = line(4)
  phase start { each agent { send agent to pen facing south } }
  schedule walk -> fire -> tick -> go -> heat -> near -> count_dens
  phase walk { move each agent }
  phase fire {
    each agent as zapper where zapper chose zap {
      mark zapline of zapper
      each agent as victim in zapline of zapper where victim.lives > 0 {
        send victim to den where den.full is no_one after delay facing north otherwise stay  tally zaps for zapper
      }
    }
  }
  phase go {
    each agent where agent chose leave and agent.lives > 1 {
      set agent.lives = agent.lives - 1  send agent to floor where floor.heat < 2 facing same otherwise stay
    }
    each agent where agent chose leave and agent.lives <= 1 { remove agent  tally gone for agent }
  }
  phase heat {
    each floor {
      let here = count(agent in square(1, centre) of floor)
      set floor.heat = case here { 0: 0, 1: 1, otherwise: 2 }
    }
  }
  phase near {
    each agent as a {
      give min(distance(a, b) over agent as b where b is not a otherwise 0) / reach to a
      give max(0.5 * c.lives over agent as c) to a
      when min(distance(a, den) over den where den.full is some otherwise reach) < 2 { tally beside for a }
    }
    each floor as f where max(distance(f, x) over agent as x otherwise 1) == 1 { when f.heat < 3 { set f.heat = f.heat + 1 } }
  }
  phase count_dens {
    each den { chance keep { set den.full = case floor_heat { yes: some, no: no_one } } otherwise { set den.full = some } }
    each agent where agent.heading is north and agent.row > 0 { give -0.5 to agent }
    when count(agent) <= 1 { end }
  }
  define floor_heat = sum(floor.heat over floor) > 6
  metrics { event zaps  event gone  event beside  mean present = count(agent)  final hot = sum(floor.heat over floor) }
}
