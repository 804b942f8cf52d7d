sj 1
game factory_commons "Factory of the Commons: Either Or" extends "shared/endings.sj" {
  about summary "Machines make apples of cubes. One sort gives the cube back beside one apple; the other gives two apples, and the cube is gone."
                "Walking tires, and workers can hold, shove and pull each other."
  cite "Agapiou et al. 2022, Melting Pot 2"  size players : count = 3 in 1 .. 16  # Melting Pot
  size  strength   : count = 18              # Melting Pot: stamina of the rested
  size  work       : steps = 17              # Melting Pot: from taking a cube in to being open again
  param first_out  : steps = 11 in 1 .. 16   # Melting Pot: a cube, or two apples, come so long after the cube went in
  param second_out : steps = 13 in 1 .. 16   # Melting Pot: the apple that follows a cube
  param pays : reward = 1  param odds : probability = 0.5  # Melting Pot: an apple; that a cube is there at first, where one may be
  param tired : count = 7 in 1 .. 18         # Melting Pot: below it, each step of walking costs a rest
  param rest : steps = 2  param long_rest : steps = 6                             # Melting Pot; the long one: at no stamina
  param soonest : steps = 1000 in 1 .. 5000  # Melting Pot: then, after each interval, the episode ends by chance
  param interval : steps = 100 in 1 .. 5000  param ending : probability = 0.1     # Melting Pot
  episode 5000                               # Melting Pot
  kind wall "#" { blocks agents, grip }  kind body "M" { blocks agents }          # of a machine
  kind floor "." {
    field place : { start, kept, perhaps, belt, upper, lower } = start
    field cube : { none, here } = none  field apple : { none, here } = none
    field cubes_due : 0 .. 9 capped = 0  field apples_due : 0 .. 9 capped = 0
    glyph "=" with place = belt  glyph "m" with place = upper  glyph "n" with place = lower  # where a machine puts what it makes
    glyph "C" with place = kept with cube = here  glyph "c" with place = perhaps  blocks agents when floor.cube is here
  }
  kind mouth "S" {
    field makes : { cube_and_apple, two_apples } = cube_and_apple  field cube : { none, here } = none  field apple : { none, here } = none
    field clock : 0 .. work = 0  glyph "G" with makes = two_apples  blocks agents when mouth.cube is here
  }
  group ground = floor, mouth  map "maps/factory_commons.txt"
  agents players {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, grasp, hold, shove, pull  moves relative
    field hand : { none, cube, apple } = none  field stamina : 0 .. strength = strength  field way : { north, east, south, west } = north
    timer resting  timer gripped  timer still  timer pushed  # set before `tick`, so to one more than the steps that follow
    forbid turn_left, turn_right, step_left, step_right, forward, backward when agent.resting > 0
    forbid hold, shove, pull when agent.gripped > 0
  }
  phase walk { move each agent where agent.still == 0 }  shape grip = line(2)  # Melting Pot
  shape reach = line(1)  define free(g) = g.cube is none and nobody on g
  define opposite(h) = case h { north: south, east: west, south: north, west: east }
  define changed(t)  = case t { here: none, none: here }
  phase start {
    each agent { send agent to floor where floor.place is start }
    each floor where floor.place is perhaps { chance odds { set floor.cube = here } }
  }
  schedule feed -> run -> walk -> land -> eat -> handle -> take_hold -> push -> tire -> tick -> finish
  phase feed {  # a cube over an open mouth is taken in, held or not
    each mouth where mouth.clock == 0 and mouth.cube is here { set mouth.cube = none  set mouth.clock = work }
    match agent as a with mouth in reach of a where a.hand is cube and mouth.clock == 0 and mouth.cube is none {
      set a.hand = none  set mouth.clock = work
    }
    each mouth where mouth.clock > 0 { set mouth.clock = mouth.clock - 1 }
  }
  phase run {
    each mouth where mouth.clock == work { tally fed[mouth.makes] }
    each floor as f where f.place is upper {
      each mouth as m in square(1) of f where m.clock == work - first_out {
        when m.makes is cube_and_apple { add 1 to f.cubes_due } otherwise { add 1 to f.apples_due }
      }
    }
    each floor as f where f.place is lower {
      each mouth as m in diamond(3) of f where m.clock == work - case m.makes { cube_and_apple: second_out, two_apples: first_out } {
        add 1 to f.apples_due
      }
    }
  }
  phase land {
    each floor where floor.cubes_due > 0 and free(floor) { set floor.cube = here  add -1 to floor.cubes_due }
    each floor where floor.apples_due > 0 and floor.apple is none { set floor.apple = here  add -1 to floor.apples_due }
  }
  phase eat { each agent on ground where ground.apple is here { set ground.apple = none  give pays to agent  tally eaten for agent } }
  phase handle {
    match agent as a with ground in reach of a where a chose grasp {
      when a.hand is none and ground.apple is here or a.hand is apple and ground.apple is none {
        set ground.apple = changed(ground.apple)  set a.hand = case a.hand { none: apple, otherwise: none }
      } otherwise when a.hand is none and ground.cube is here or a.hand is cube and free(ground) {
        set ground.cube = changed(ground.cube)  set a.hand = case a.hand { none: cube, otherwise: none }
      }
    }
  }
  phase take_hold {  # both miss the next step of walking
    each agent as a where a chose hold or a chose shove or a chose pull {
      mark grip of a
      first agent as v in grip of a {
        set v.gripped = 2  set v.still = 2  set a.still = 2
        when not a chose hold { set v.pushed = 1  set v.way = case a chose shove { yes: a.heading, no: opposite(a.heading) } by lot }
      }
    }
  }
  phase push { each agent where agent.pushed > 0 { send agent by 1 agent.way facing same otherwise stay } }
  phase tire {
    each agent where agent.resting == 0 {
      when agent chose forward or agent chose backward or agent chose step_left or agent chose step_right {
        let left = max(agent.stamina - 1, 0)  set agent.stamina = left
        when left < tired { set agent.resting = 1 + case left { 0: long_rest, otherwise: rest } }
      } otherwise { set agent.stamina = min(agent.stamina + 1, strength) }
    }
  }
  phase finish { when may_end(soonest, interval) { chance ending { end } } }
  look floor where floor.place is belt as "#cfc8bb"
  observe {
    show other.index  show agent.hand  show other.hand  show agent.stamina  show other.stamina  show agent.gripped
    show mouth.clock as { open where mouth.clock == 0, shut }  show floor.place as { belt where floor.place is belt, bare }
  }
  metrics { event eaten  event fed by { cube_and_apple, two_apples }  mean cubes = count(ground where ground.cube is here) }
  checks {
    symmetric agents  require tired <= strength  always count(agent on ground where ground.cube is here) == 0
    always count(agent where agent.resting > 0 and agent.stamina >= tired) == 0
    expect eaten == 0 and fed[cube_and_apple] == 0 and fed[two_apples] == 0 with never(grasp) over 3 episodes
    expect eaten > 0 and fed[two_apples] == 0 with cooperator over 1 episodes
  }
  define feeds(a, m, sort) = a.hand is cube and m.makes is sort and m.clock == 0
  policy cooperator "feeds the machines that give the cube back, and eats" {
    seek ground where ground.apple is here avoiding ground where ground.cube is here
    aim reach at mouth where feeds(agent, mouth, cube_and_apple) avoiding floor where floor.cube is here choose stay
    aim reach at floor where agent.hand is none and floor.cube is here avoiding floor as other where other.cube is here choose grasp
  }
  policy defector "feeds the machines that use the cube up, and eats" {
    seek ground where ground.apple is here avoiding ground where ground.cube is here
    aim reach at mouth where feeds(agent, mouth, two_apples) avoiding floor where floor.cube is here choose stay
    aim reach at floor where agent.hand is none and floor.cube is here avoiding floor as other where other.cube is here choose grasp
  }
  variant released "as released: all machines share a variable of the code, and a machine that is fed while another works jams its sort" {
    field jammed by { cube_and_apple, two_apples } : 0 .. 2 capped = 0  # for good; 1: what flies already still lands
    define earlier(a, b) = a.row < b.row or a.row == b.row and a.col < b.col
    # Melting Pot
    define at_work(m)    = count(mouth as o where o is not m and o.clock >= work - 16 and (o.clock < work or earlier(o, m))) > 0
    schedule feed -> run -> jam -> walk -> land -> eat -> handle -> take_hold -> push -> tire -> tick -> finish
    phase jam {  # the mouth stays open
      when jammed[cube_and_apple] == 1 { add 1 to jammed[cube_and_apple] }
      when jammed[two_apples] == 1 { add 1 to jammed[two_apples] }
      each mouth where mouth.clock == work and at_work(mouth) { add 1 to jammed[mouth.makes]  set mouth.clock = 0 }
    }
    phase run {
      each mouth where mouth.clock == work { tally fed[mouth.makes] }
      each floor as f where f.place is upper {
        each mouth as m in square(1) of f where m.clock == work - first_out and jammed[m.makes] < 2 {
          when m.makes is cube_and_apple { add 1 to f.cubes_due } otherwise { add 1 to f.apples_due }
        }
      }
      each floor as f where f.place is lower {
        each mouth as m in diamond(3) of f where case m.makes {
          cube_and_apple: m.clock == work - second_out and jammed[cube_and_apple] == 0,
          two_apples: m.clock == work - first_out and jammed[two_apples] < 2 } {
          add 1 to f.apples_due
        }
      }
    }
    phase land {  # Melting Pot: who stands there destroys the cube
      each floor where floor.cubes_due > 0 { set floor.cubes_due = 0  when free(floor) { set floor.cube = here } }
      each floor where floor.apples_due > 0 and floor.apple is none { set floor.apple = here  add -1 to floor.apples_due }
    }
  }
}
