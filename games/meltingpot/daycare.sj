sj 1
game daycare "Daycare" {
  cite "Agapiou et al. 2022, Melting Pot 2"
  about summary "A child lives on bananas, and cannot reach those in trees. A parent reaches everything, but cannot tell bananas from apples,"
                "and likes both, as long as the child is there. So the child has to show what it wants, and the parent to look after it."
  size  players : count       = 2 in 2 .. 16  # Melting Pot: a child and a parent, in turn
  size  longest : steps       = 200           # Melting Pot
  param hungry  : steps       = 200 in 1 .. 200   # Melting Pot: a child that eats no banana for so long is away
  param absence : steps       = 100 in 0 .. 1000  # Melting Pot
  param regrow  : steps       = 50 in 0 .. 200    # Melting Pot: from eating to the next fruit of the same plant
  param luck    : probability = 0.3           # Melting Pot: that a child picks a fruit of a shrub
  param pays    : reward      = { child: { none: 0, apple: 0, banana: 1 }, parent: { none: 0, apple: 1, banana: 1 } }  # Melting Pot
  size  far     : cells       = 63            # ours: rows and columns need a bound
  episode 1000                                # Melting Pot
  kind wall "#" { blocks agents, reach }
  kind plot "~" {
    field yard : { outside_it, inside_it } = outside_it
    glyph "P" with yard = inside_it
    glyph "b" with yard = inside_it with plant = banana_shrub with fruit = ripe
    field plant : { bare, apple_tree, apple_shrub, banana_tree, banana_shrub } = bare
    field fruit : { none, ripe, growing } = none  field lies : { none, apple, banana } = none
    field row_of : 0 .. far = 0  field col_of : 0 .. far = 0  # the plant of what lies here
    timer left  field carriers : set of agent                 # who holds a fruit over this plot
  }
  map "maps/daycare.txt"
  agents players {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, eat, grasp
    moves relative
    field role : { child, parent } = child
    field hand : { none, apple, banana } = none
    field row_of : 0 .. far = 0  field col_of : 0 .. far = 0                         # the plant of what is in the hand
    field ate : { nothing, just_now } = nothing  field grip : { open, shut } = open  # Melting Pot: a grasp counts if the last step was none
    field hunger : 0 .. longest = longest
  }
  shape reach = line(1)
  define is_banana(p) = p.plant in { banana_tree, banana_shrub }
  define is_tree(p)   = p.plant in { apple_tree, banana_tree }
  phase start {
    each agent {
      when agent.index % 2 == 1 { set agent.role = parent }  set agent.hunger = hungry  send agent to plot where plot.yard is inside_it
    }
    each plot where plot.yard is outside_it {  # Melting Pot
      draw what from { bare: 0.8, apple_tree: 0.15, apple_shrub: 0.01, banana_tree: 0.03, banana_shrub: 0.01 }
      set plot.plant = what  when what is not bare { set plot.fruit = ripe }
    }
  }
  schedule starve -> eat -> walk -> hold -> let_go -> take -> faint -> sow -> leave -> tick -> ripen
  phase starve { each agent where agent.role is child and agent.hunger > 0 { set agent.hunger = agent.hunger - 1 } }
  phase eat {
    each agent where agent chose eat and agent.hand is not none {
      when agent.role is child or count(agent as other where other.role is child) > 0 { give pays[agent.role][agent.hand] to agent }
      when agent.role is child and agent.hand is banana { set agent.hunger = hungry }
      set agent.hand = none  set agent.ate = just_now  tally eaten[agent.hand] for agent
    }
  }
  phase walk { move each agent }
  phase hold {
    each agent where agent chose grasp and agent.grip is open { mark reach of agent }
    each agent where agent.hand is not none { first plot in reach of agent { add agent to plot.carriers } }
  }
  phase let_go {
    match agent as giver with plot in reach of giver where giver chose grasp and giver.grip is open and giver.hand is not none
        and plot.plant is bare and plot.lies is none {
      set plot.lies = giver.hand  set plot.row_of = giver.row_of  set plot.col_of = giver.col_of
      set giver.hand = none  set giver.grip = shut  tally dropped[giver.hand] for giver
    }
  }
  phase take {
    match agent as taker with plot in reach of taker where taker chose grasp and taker.grip is open and taker.hand is none {
      when plot.lies is not none {
        set taker.hand = plot.lies  set taker.row_of = plot.row_of  set taker.col_of = plot.col_of  set plot.lies = none
      } otherwise when count(agent as owner in plot.carriers where owner.hand is not none) > 0 {
        pick 1 agent as owner in plot.carriers where owner.hand is not none {  # Melting Pot: out of another's hand
          set taker.hand = owner.hand  set taker.row_of = owner.row_of  set taker.col_of = owner.col_of  set owner.hand = none
        }
      } otherwise when plot.fruit is ripe and (taker.role is parent or not is_tree(plot)) {
        chance case taker.role { child: luck, parent: 1 } {
          set taker.hand = case is_banana(plot) { yes: banana, no: apple }  set taker.row_of = plot.row  set taker.col_of = plot.col
          set plot.fruit = none  tally picked for taker
        }
      }
    }
    each agent { set agent.grip = case agent chose grasp { yes: shut, no: open } }  each plot { set plot.carriers = nobody }
  }
  phase faint {
    each agent where agent.hunger == 0 { set agent.ate = case agent.hand { none: agent.ate, otherwise: just_now }  set agent.hand = none }
  }
  phase sow {
    each agent where agent.ate is just_now {
      set agent.ate = nothing
      each plot where plot.row == agent.row_of and plot.col == agent.col_of { set plot.fruit = growing  set plot.left = regrow + 2 }
    }
  }
  phase leave {
    each agent where agent.hunger == 0 {
      set agent.hunger = hungry  set agent.grip = open
      send agent to plot where count(agent as p in disc(1, centre) of plot where p.role is parent) > 0 after absence + 2 facing north
          otherwise stay
    }
  }
  phase ripen { each plot where plot.fruit is growing and plot.left == 0 { set plot.fruit = ripe } }
  look plot where plot.plant is apple_tree as tree  look plot where plot.plant is banana_tree as "#a8962a" tree
  look plot where plot.plant is apple_shrub as bush  look plot where plot.plant is banana_shrub as "#a8962a" bush
  look plot where plot.fruit is ripe and plot.plant in { apple_tree, apple_shrub }   with red apple
  look plot where plot.fruit is ripe and plot.plant in { banana_tree, banana_shrub } with banana
  observe {
    show plot.plant as {
      apple_tree where agent.role is parent and plot.plant in { apple_tree, banana_tree },
      apple_shrub where agent.role is parent and plot.plant in { apple_shrub, banana_shrub } or plot.plant in { apple_tree, apple_shrub },
      banana_shrub where plot.plant in { banana_tree, banana_shrub }, bare }
    show plot.fruit as { ripe where plot.fruit is ripe, empty }
    show plot.lies as {
      apple where plot.lies is apple or agent.role is parent and plot.lies is banana, banana where plot.lies is banana, nothing }
    show other.hand as { nothing where other.hand is none, banana where other.hand is banana and agent.role is child, apple }
    show agent.hand as { nothing where agent.hand is none, banana where agent.hand is banana and agent.role is child, apple }
    show agent.role  show other.role  show agent.hunger  hide plot.yard
  }
  metrics { event eaten by { none, apple, banana }  event dropped by { none, apple, banana }  event picked }
  checks { always count(plot where plot.lies is not none and plot.plant is not bare) == 0 }
  policy forager "picks what it can, and eats it" {
    when agent.hand is not none choose eat  when agent.grip is shut choose stay
    aim reach at plot where plot.lies is not none or plot.fruit is ripe and (agent.role is parent or not is_tree(plot)) choose grasp
  }
}
