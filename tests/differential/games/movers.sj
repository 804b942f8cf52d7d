sj 1
game movers "Movers of several sorts: fleeing, hunting, rolling, drifting, riding on belts; caught, reborn, removed" {
  size  herd   : count  = 3 in 1 .. 8
  param caught : reward = 1
  param delay  : steps  = 3 in 0 .. 6
  episode 60
  field tally_of_deer : 0 .. 99 capped = 0
  kind grass "." { field grown : { bare, lush } = lush  glyph "," with grown = bare }
  kind wall  "#" { blocks agents, deer, wolf, cart, ball }
  kind belt  ">" {
    field way : { stop, east, south } = east  blocks agents, ball, deer  glyph "v" with way = south  glyph "=" with way = stop
  }
  kind door  "D" {
    field state : { open, shut } = shut
    blocks agents, deer when door.state is shut
    blocks wolf when wolf.hungry < 2 and door.state is shut
  }
  group ground = grass, belt
  map {
    ".,..#..."
    "..D.#,.."
    "....D..."
    "##.>>=.."
    "...v..,."
    ".....#.."
  }
  agents 3 {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, kick, push
    moves relative
    field bag : 0 .. 9 capped = 0
  }
  movers deer herd "d" { field fear : { calm, scared } = calm  timer rest  field owner : agent }
  movers wolf 2 "w" { field hungry : 0 .. 5 capped = 0  field prey by { near_one, far_one } : 0 .. 9 capped = 0 }
  movers ball 2 "o" { field rolling : { yes, no } = no }
  movers cart 1 "c" { field load : set of agent }
  shape ray = line(3)
  phase start {
    each agent { send agent to grass }
    each deer { send deer to grass facing south }
    each wolf { when wolf.index == 0 { send wolf to belt } otherwise { send wolf to grass where grass.grown is lush } }
    each ball { send ball to grass facing east }
    each cart { send cart to belt facing east }
  }
  schedule tick -> walk -> flee -> hunt -> roll -> ride -> drift(1) -> act -> shove -> stop -> meet
  phase walk { move each agent }
  phase flee {
    move each deer where deer.rest == 0 away from agent as hunter where distance(hunter, deer) <= 3 and hunter.bag < 9 avoiding grass
        where grass.grown is bare
  }
  phase hunt { move each wolf toward deer in disc(3) of wolf avoiding ball }
  phase roll { move each ball where ball.rolling is yes ahead }
  phase ride { move each cart on belt where belt.way is not stop along belt.way }
  phase drift(n) { move each deer where deer.fear is calm and deer.index == n at random avoiding agent }
  phase act {
    pick 1 agent as a where a chose kick {
      first ball in ray of a { set ball.rolling = yes  set ball.heading = a.heading }
      when count(ball in ray of a) == 0 { first deer in ray of a { set deer.fear = scared  set deer.owner = a  tally hit for a } }
    }
    each wolf on ground as here where wolf.hungry < 5 {
      add 1 to wolf.hungry
      add 1 to wolf.prey[near_one]
      when here.row > 2 { set wolf.prey[far_one] = count(deer in disc(2) of wolf) }
    }
    each door { chance 0.3 { set door.state = case door.state { open: shut, shut: open } } }
    pick 1 deer as chosen where chosen.fear is scared { add 1 to tally_of_deer }
    each grass where nobody on grass { chance 0.05 { set grass.grown = lush } }
  }
  phase shove {
    pick 1 agent as a where a chose push {
      first ball in line(1) of a {
        send ball by 1 a.heading facing north otherwise stay
        send a by 1 ahead otherwise stay
      }
      when count(ball in line(1) of a) == 0 { pick 1 cart in disc(2) of a { send cart by 2 away from a otherwise stay } }
    }
    each wolf where wolf.hungry > 4 { send wolf by 1 back facing south otherwise stay }
  }
  phase stop {
    each ball where ball.rolling is yes and not ball.moved and nobody_chose(ball) { set ball.rolling = no }
    each deer on grass { set grass.grown = bare }
  }
  phase meet {
    match wolf with first deer in line(1) of wolf where deer.rest == 0 {
      send deer to grass where grass.grown is lush after delay facing same otherwise stay
      set deer.rest = delay  set deer.fear = calm
      set wolf.hungry = 0
    }
    each cart { each agent in disc(2) of cart { add agent to cart.load } }
    each agent as a { let close = count(deer in disc(1) of a)  add close to a.bag  give caught * close to a }
    each ball as one {
      each ball as other where one is not other and distance(one, other) == 1 { when one.index < other.index { remove one } }
    }
  }
  define nobody_chose(b) = count(agent as x in disc(3) of b where x chose kick) == 0
  observe {
    window ahead 3, behind 2, left 2, right 2
    show deer.fear
    show deer.heading
    show deer.owner as { mine where deer.owner is agent, theirs where deer.owner is not nobody, free }
    show wolf.hungry when wolf.index == 0
    show wolf.heading when agent.bag < 3
    hide wolf when agent.bag > 4 and wolf.hungry > 2
    hide cart
    show agent.bag
  }
  metrics {
    event hit
    mean calm_ones = count(deer where deer.fear is calm)
    mean hunger = sum(wolf.hungry over wolf)
    final balls = count(ball)
  }
}
