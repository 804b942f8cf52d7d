sj 1
game paintball "Paintball: Capture the Flag" {
  cite "Agapiou et al. 2022"
  about summary "Two teams paint the ground and each other. Nobody can leave ground of the other team's colour without painting it;"
                "one's own colour heals. A team scores when a player carries the other's flag home while its own is there."
  about our_paradigm "team competition"  # ours: zero-sum between teams, a common interest within each

  size players : count = 8 in 2 .. 32                       # Melting Pot; even numbers are red, odd ones blue
  size full : count = 5  size absence : steps = 81          # Melting Pot: hits that break a wall; how long who is shot is away
  param length : steps = 1000  episode length  param score : reward = 1  # Melting Pot; score: to each of a team, from each of the other
  param broken  : probability = { door: 0.1, hatch: 0.25 }  # Melting Pot: walls that begin broken
  param healing : probability = 0.05                        # Melting Pot: one point of health, per step
  param most_own : count = 3 in 0 .. 3  param most : count = 2 in 0 .. 3  # Melting Pot: up to there, on one's own colour, on none
  param spray_pause : steps = 2 in 0 .. 255  param snipe_pause : steps = 4 in 0 .. 255  # Melting Pot
  kind wall    "#" { blocks agents, spray, snipe, shot }
  kind ground  "." {
    field paint : { clean, red, blue } = clean  field shooters : set of agent  field flag : { none, red, blue } = none
    field site : { plain, sign, hill, red_gate, blue_gate, red_home, blue_home } = plain  # signs show `control`, and take no paint
    glyph "I" with site = sign  glyph "G" with site = hill  glyph "P" with site = red_gate  glyph "Q" with site = blue_gate
    glyph "R" with site = red_home with flag = red  glyph "B" with site = blue_home with flag = blue
  }
  kind barrier "D" {
    field sort : { door, hatch } = door  glyph "H" with sort = hatch
    field health : 0 .. full capped = full  field shooters : set of agent  field flag : { none, red, blue } = none
    blocks agents when barrier.health > 0  blocks spray, snipe, shot when barrier.health > 1  # Melting Pot: the last shot goes through
  }
  group land = ground, barrier  map "maps/paintball_capture_the_flag.txt"
  field control : { neither, red, blue, both } = both  # which flags are at home, so that the team can score
  field reds    : set of agent                         # the red team, those away too
  agents players {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, spray, snipe  moves relative
    field team : { red, blue } = red  timer cooling
    field health : 0 .. 3 capped = 2  field load : { none, flag } = none  field feet : { free, stuck } = free  # Melting Pot
    forbid turn_left, turn_right, step_left, step_right, forward, backward when agent.feet is stuck
    forbid spray, snipe when agent.cooling > 0  forbid snipe when agent.moved  # Melting Pot: only after a step without a move
  }
  shape spray = fan(3, 1)  shape snipe = line(6)                  # Melting Pot
  shape shot { ".x."  ".x."  ".x."  ".x."  "xxx"  "xxx"  "x^x" }  # both
  define in_line(a, b, place) = case a.heading in { north, south } { yes: b.col == place.col, no: b.row == place.row }
  define reaches(a, place) = a chose spray and distance(a, place) <= 3 or a chose snipe and in_line(a, a, place)  # Melting Pot
  define shields(a, b, place) = b.team is not a.team and b.health == 1 and in_line(a, b, place) and distance(a, b) < distance(a, place)
  define reached(a, place) = reaches(a, place) and count(agent as b in shot of a where shields(a, b, place)) == 0
  define lost(hue) = count(land where land.flag is hue) == 0 and count(agent where agent.team is not hue and agent.load is flag) == 0
  define gate(hue) = case hue { red: red_gate, blue: blue_gate }  define rival(hue) = case hue { red: blue, blue: red }
  define safe(hue) = count(ground where ground.site is case hue { red: red_home, blue: blue_home } and ground.flag is hue) > 0
  phase start {
    each agent as a {
      when a.index % 2 == 0 { add a to reds  send a to ground where ground.site is red_gate }  # Melting Pot
      otherwise { set a.team = blue  send a to ground where ground.site is blue_gate }
    }
    each barrier { chance broken[barrier.sort] { set barrier.health = 0 } }
  }
  schedule tick -> walk -> carry -> fire -> settle -> fall -> heal -> restore -> signal
  phase walk { move each agent }
  phase carry {  # who comes to a flag, or stands where one comes
    each agent as a on land where land.flag is not none {
      let flag_of = land.flag
      when flag_of is not a.team or not safe(a.team) { set land.flag = none }
      when flag_of is not a.team { set a.load = flag  tally taken for a }
      otherwise when not safe(a.team) { tally returned for a }
      otherwise when a.load is flag {
        set a.load = none  tally captured for a
        when a.team is red { give -1 * score to all  give 2 * score to reds }
        otherwise { give score to all  give -2 * score to reds }
      }
    }
  }
  phase fire {  # a lane ends at who is shot down
    each agent as a where a chose spray { mark spray of a  set a.cooling = spray_pause }
    each agent as a where a chose snipe { mark snipe of a  set a.cooling = snipe_pause }
    each agent as a { each land in shot of a where reached(a, land) { add a to land.shooters } }
    each agent as a on ground where a chose spray { add a to ground.shooters }  # Melting Pot: one's own cell, too
  }
  phase settle {  # of all who paint a cell in a step, one is the last
    each ground where ground.shooters is not nobody and ground.site is not sign {
      pick 1 agent as last in ground.shooters { set ground.paint = last.team }
    }
    each barrier { each agent in barrier.shooters { add -1 to barrier.health }  set barrier.shooters = nobody }
    each agent as b on land { each agent as a in land.shooters where a.team is not b.team { add -1 to b.health  tally hits for a } }
    each ground { set ground.shooters = nobody }
  }
  phase fall {
    each agent as a where a.health == 0 {
      set a.health = 2  set a.load = none  set a.feet = free  tally shot for a  # Melting Pot
      send a to ground where ground.site is gate(a.team) after absence otherwise stay
    }
    each agent as a on land where a.health == 0 and a.load is flag and land.flag is none { set land.flag = rival(a.team) }
  }
  phase heal {
    each agent as a on ground {
      let hue = ground.paint
      when hue is a.team { set a.feet = free } otherwise when hue is not clean { set a.feet = stuck }
      when a.health < case hue { clean: most, otherwise: case hue is a.team { yes: most_own, no: 0 } } {
        chance healing { add 1 to a.health }
      }
    }
    each agent as a on barrier where a.health < most { chance healing { add 1 to a.health } }  # Melting Pot: as on clean ground
  }
  phase restore {  # a flag that is nowhere else is at home
    each ground where ground.site is red_home and lost(red) { set ground.flag = red }
    each ground where ground.site is blue_home and lost(blue) { set ground.flag = blue }
  }
  phase signal {
    set control = case safe(red) { yes: case safe(blue) { yes: both, no: red }, no: case safe(blue) { yes: blue, no: neither } }
  }
  look ground where ground.site is hill as "#efdca0"  look ground where ground.site is sign as "#c9c4ba"
  look ground where ground.site is red_home as "#e3c7c0"  look ground where ground.site is blue_home as "#c4cde3"
  look ground where ground.paint is red as "#e8a0a8"  look ground where ground.paint is blue as "#a0b0e8"
  look barrier where barrier.health > 0 as "#dcc6b8" wall  look barrier where barrier.health > 2 as "#b98d74" wall
  look agent where agent.team is red as red  look agent where agent.team is blue as blue
  look agent where agent.team is red and agent.load is flag  with blue flag
  look agent where agent.team is blue and agent.load is flag with red flag
  observe {
    window ahead 9, behind 1, left 5, right 5  show control  hide barrier.sort                         # Melting Pot
    show agent.team  show agent.health  show agent.cooling  show agent.load  show other.team  show other.health  show other.load
    show ground.site as { red_home where ground.site is red_home, blue_home where ground.site is blue_home, plain }
    show barrier.health as { whole where barrier.health > 2, damaged where barrier.health > 0, gone }  # Melting Pot
  }
  metrics { event hits  event shot  event taken  event returned  event captured }
  checks {
    symmetric agents  always count(agent where agent.health == 0) == 0 and count(land where land.shooters is not nobody) == 0
    expect hits == 0 and shot == 0 with never(spray, snipe) over 3 episodes
  }
}
