sj 1
game boat_race "Boat Race: Eight Races" {
  cite "Agapiou et al. 2022"
  about summary "Six players race across a river and back, two in a boat. A boat glides when both row at once; who rows while the other flails"
                "is hurt, and flailing alone gets there slowly. Apples grow on the far bank, and who has not landed in time is out."
  about our_paradigm "stag hunt"                   # ours: rowing together is best, flailing is safe
  about our_multi_task "yes"                       # ours: choosing a partner, rowing, eating
  size players : count = 6 in 2 .. 6               # Melting Pot
  param length : steps = 2400  episode length      # Melting Pot: eight times 300
  param cycle : steps = 299 in 4 .. 1000           # Melting Pot: 70 to choose partners, 226 to race, 3 to clear up
  param ready : steps = 65                         # Melting Pot: the lights turn yellow
  param off   : steps = 71                         # Melting Pot: the barriers open
  param apple : reward = 1  param regrow : probability = 0.1                             # Melting Pot
  param flail_moves : probability = 0.1            # Melting Pot: that a boat moves when somebody in it flails
  param mismatch    : reward      = -0.5           # Melting Pot: of who rows while the other flails
  param pause       : steps       = 4 in 0 .. 255  # Melting Pot: one stroke in five steps
  kind floor "."
  kind shore "h" { field side : { north, south } = north  glyph "H" with side = south }  # Melting Pot: three cells from the dock
  kind gate "P"  kind wall "#" { blocks agents }  kind light "l" { blocks agents }       # shows `lights` to all
  kind river   "~" { blocks agents }
  kind tree    "N" {
    field side : { north, south } = north  field fruit : { none, ripe } = ripe  glyph "S" with side = south with fruit = none
  }
  kind barrier "n" {
    field side : { north, south } = north  field gate : { open, shut } = open  glyph "s" with side = south with gate = shut
    blocks agents when barrier.gate is shut
  }
  kind lane    "w" { blocks agents when agent.state is not rowing }
  kind bunch   "a" { field fruit : { none, ripe } = ripe  blocks agents when agent.state is not rowing }  # apples over the water
  kind dock    "b" {
    field side : { north, south } = north  field boat : { none, here } = none  glyph "B" with side = south with boat = here
    blocks agents when dock.boat is none and agent.state is not rowing
  }
  group orchard = tree, bunch  map "maps/boat_race.txt"
  field bound  : { north, south } = north  # where the race goes
  field lights : { red, yellow, green } = red
  agents players {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, row, flail
    moves relative  field state : { ashore, rowing, landed } = ashore
    field stroke : { none, row, flail } = none  field glides : { no_, yes_ } = no_  timer arms
    forbid turn_left, turn_right, step_left, step_right, forward, backward when agent.state is rowing
    forbid row when agent.state is not rowing or agent.arms > 0  forbid flail when agent.state is not rowing
  }
  define next = (step + 1) % cycle  define racing = next >= off and not done and not last
  define done = next + 2 == cycle  # Melting Pot: then the lights turn red, and who has not landed is out, ...
  define last = next + 1 == cycle  # ... and a step later all is turned round

  phase start { each agent { send agent to gate } }
  schedule tick -> walk -> board -> pull -> glide -> land -> grow -> eat -> clear -> signal

  phase grow { each tree where tree.side is bound and tree.fruit is none { chance regrow { set tree.fruit = ripe } } }  # under players, too
  phase walk { move each agent }
  phase board { each agent on dock where agent.state is ashore { set agent.state = rowing  tally boarded for agent } }
  phase pull {
    each agent as a where a chose row { set a.stroke = row  set a.arms = pause }
    each agent as a where a chose flail { set a.stroke = flail }
    each agent as a where not a chose row and not a chose flail { set a.stroke = none }
    match agent as a with agent as b in diamond(1) of a where a.state is rowing and b.state is rowing and a.row == b.row {
      when a chose row and b chose row { set a.glides = yes_  set b.glides = yes_ }
      otherwise when a chose flail or b chose flail {
        chance flail_moves { set a.glides = yes_  set b.glides = yes_ }
        when a chose row { give mismatch to a  tally hurt for a }  when b chose row { give mismatch to b  tally hurt for b }
      }
    }
  }
  phase glide {
    each agent on dock where agent.glides is yes_ { set dock.boat = none }
    each agent where agent.glides is yes_ { send agent by 1 bound facing same otherwise stay  set agent.glides = no_ }
  }
  phase land {
    each agent on dock where agent.state is rowing and dock.side is bound {
      set dock.boat = here  set agent.state = landed  tally landed for agent
      send agent to shore where shore.side is bound and shore.col == agent.col facing same otherwise stay
    }
  }
  phase eat { each agent on orchard where orchard.fruit is ripe { set orchard.fruit = none  give apple to agent  tally eaten for agent } }
  phase clear {
    when done {
      each agent where agent.state is landed { set agent.state = ashore }
      each agent where agent.state is not landed { remove agent  tally out_of_race for agent }
    }
    when last {
      set bound = case bound { north: south, south: north }
      each tree { set tree.fruit = case tree.side is bound { yes: none, no: ripe } }  each bunch { set bunch.fruit = ripe }
    }
    when count(agent) == 0 and step % 100 == 0 { end }  # Melting Pot: looked at in every hundredth step
  }
  phase signal {
    set lights = case racing { yes: green, no: case next >= ready and next < off { yes: yellow, no: red } }
    each barrier {
      set barrier.gate = case (barrier.side is bound) {
        yes: case racing or done { yes: shut, no: open }, no: case racing or done { yes: open, no: shut } }
    }
  }

  look river as blue water  look lane as "#86b4d6" water  look bunch as "#86b4d6" water
  look dock as "#86b4d6" water  look dock where dock.boat is here as boat
  look tree where tree.side in { north, south } as tree  look agent where agent.state is rowing as boat
  look barrier where barrier.side in { north, south } as "#e2dccb"  look barrier where barrier.gate is shut as door
  observe {
    window ahead 9, behind 1, left 5, right 5  # Melting Pot
    show agent.index
    show other.index
    show agent.state
    show agent.arms
    show other.state
    show other.stroke
    show lights
    show shore as { floor }
  }
  metrics { event boarded  event hurt  event landed  event eaten  event out_of_race }
  checks {
    symmetric agents  require ready < off and off + 2 < cycle
    require mismatch < 0 and flail_moves < 1  # rowing together is faster, and flailing hurts who rows
    always landed <= boarded  always count(barrier where lights is green and barrier.side is bound and barrier.gate is open) == 0
    expect hurt == 0 with never(flail) over 3 episodes  expect landed == 0 and eaten == 0 with never(row, flail) over 3 episodes
    expect landed > 0 and hurt == 0 with cooperator over 1 episodes
  }
  define mates(place) = count(agent as mate in diamond(1) of place where mate.state is rowing and mate.row == place.row)
  define set_out(a)   = count(agent as mate in diamond(1) of a where mate.state is rowing and mate.row == a.row and mate.arms == 0) > 0
  define free(d)      = d.boat is here and d.side is not bound and nobody on d
  policy cooperator "takes a seat, beside somebody if it can, and rows when both are ready; then it eats" {
    when agent.state is rowing and agent.arms == 0 and set_out(agent) choose row
    when agent.state is rowing choose stay  seek dock where agent.state is ashore and free(dock) and mates(dock) > 0
    seek dock where agent.state is ashore and free(dock)
    seek tree where agent.state is landed and tree.side is bound and tree.fruit is ripe
  }
  policy defector "takes a seat and flails" {
    when agent.state is rowing choose flail  seek dock where agent.state is ashore and free(dock) and mates(dock) > 0
    seek dock where agent.state is ashore and free(dock)
    seek tree where agent.state is landed and tree.side is bound and tree.fruit is ripe
  }
}
