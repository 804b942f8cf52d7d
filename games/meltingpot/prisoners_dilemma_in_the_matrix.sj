sj 1
game prisoners_dilemma_in_the_matrix "Prisoner's Dilemma in the Matrix" extends "shared/endings.sj" {
  cite "Vezhnevets et al. 2020; Agapiou et al. 2022; the_matrix of Melting Pot 2"
  about summary "Players gather resources, one for each strategy, and challenge each other with a beam: the mixture that each of the"
                "two holds is its strategy. Defecting pays more in every meeting; two cooperators earn more than two defectors."
  about our_paradigm "prisoner's dilemma"  # Melting Pot

  size players : count = 8 in 2 .. 64                # Melting Pot
  size room    : count = 100                         # ours: a bag needs a bound; it holds no more of each
  size classes : count = 2  size health : count = 3  # Melting Pot: one of each is held from the start; hits that destroy a resource
  param longest : steps = 5000  episode longest      # Melting Pot
  # Melting Pot: from then on the episode may end, each so many steps, with this probability
  param soonest : steps = 1000  param interval : steps = 100 in 1 .. 5000  param ending : probability = 0.15
  param regrow  : probability = 0.04                 # Melting Pot: that a resource comes back, per step, ...
  param delay   : steps       = 11 in 0 .. 255       # Melting Pot: ... from so many steps on
  param cooling : steps       = 2 in 0 .. 255        # Melting Pot: without a beam after a beam
  param freeze  : steps       = 17 in 0 .. 200       # Melting Pot: from the meeting to its rewards
  size  absence : steps       = 51 in 0 .. 1000      # Melting Pot: of both, after that
  param payoff  : reward      = { coop: { coop: 3, defect: 0 }, defect: { coop: 5, defect: 1 } }              # Melting Pot
  param edge_1 : reward = 1  param edge_2 : reward = 2  param edge_3 : reward = 3  param edge_4 : reward = 4  # Melting Pot: colours

  kind floor "."  kind gate "P"
  kind wall  "#" { blocks agents, beam }
  kind patch "1" {
    field class : { coop, defect } = coop  glyph "2" with class = defect
    field sort : { fixed, drawn } = fixed  glyph "a" with sort = drawn  # Melting Pot: any of the classes, in each episode
    field stock  : { none, ripe } = ripe
    field damage : 0 .. health capped = 0
    timer young
    blocks beam when patch.stock is ripe and patch.damage + 1 < health  # Melting Pot: beams go on through what they destroy
  }
  map "maps/matrix_arena.txt"  # Melting Pot

  agents players {
    acts stay, forward, backward, step_left, step_right, turn_left, turn_right, interact  # Melting Pot: in this order
    moves relative  blocks beam
    field bag by { coop, defect } : 0 .. room capped = 1
    # Melting Pot: in its step a meeting shows both bags
    field brought by { coop, defect } : 0 .. room = 0  field faced by { coop, defect } : 0 .. room = 0
    field badge  : 0 .. players = 0  # others see it: players have colours of their own
    field owed   : reward
    field rivals : set of agent
    field sign   : { unready, ready, red, yellow, green, blue, violet } = unready  # seen by all: who is ready, and what a meeting comes to
    timer frozen  forbid all when agent.frozen > 0  timer hot  forbid interact when agent.hot > 0
  }
  shape beam = fan(3, 1)  # Melting Pot
  define can_meet(who) = sum(who.bag) > classes and who.frozen == 0

  phase start {
    each agent { send agent to gate  set agent.badge = agent.index + 1 }
    each patch where patch.sort is drawn { draw hue from { coop, defect }  set patch.class = hue }
  }

  schedule walk -> tick -> collect -> aim -> wreck -> meet -> settle -> grow -> sign -> close
  phase walk { move each agent }
  phase collect {
    each agent { set agent.brought = 0  set agent.faced = 0 }  # no bag is empty: none of it is shown
    each agent on patch where patch.stock is ripe {
      set patch.stock = none  set patch.young = delay  add 1 to agent.bag[patch.class]  tally collected[patch.class] for agent
    }
  }
  phase aim {
    each agent as row where row chose interact {
      mark beam of row  set row.hot = cooling
      first agent as column in beam of row { when can_meet(row) and can_meet(column) { add row to column.rivals } }
      each patch in beam of row where patch.stock is ripe { add 1 to patch.damage }
    }
  }
  phase wreck {
    each patch where patch.damage == health {
      set patch.damage = 0  set patch.stock = none  set patch.young = delay  tally destroyed[patch.class]
    }
  }
  phase meet {
    match agent as column with agent as row in column.rivals where sum(row.bag) > classes and sum(column.bag) > classes {
      set row.owed = payoff[mix(row.bag)][mix(column.bag)]
      set column.owed = payoff[mix(column.bag)][mix(row.bag)]  # the same matrix, roles swapped
      set row.brought = row.bag  set row.faced = column.bag  set column.brought = column.bag  set column.faced = row.bag
      each agent as one in { row, column } { set one.frozen = freeze + 1  tally met for one }
    }
    each agent where agent.rivals is not nobody { set agent.rivals = nobody }
  }
  phase settle {
    each agent where agent.frozen == 1 { give agent.owed to agent  set agent.bag = 1  send agent to gate after absence }
  }
  phase grow {
    each patch where patch.stock is none and patch.young == 0 and nobody on patch { chance regrow { set patch.stock = ripe } }
  }
  phase sign {
    each agent where agent.frozen == 0 { set agent.sign = case sum(agent.bag) > classes { no: unready, yes: ready } }
    each agent as a where a.frozen > 0 {
      set a.sign = case a.owed < edge_2 {
        yes: case a.owed < edge_1 { yes: red, no: yellow },
        no: case a.owed < edge_4 { yes: case a.owed < edge_3 { yes: green, no: blue }, no: violet } }
    }
  }
  phase close { when may_end(soonest, interval) { chance ending { end } } }
  look patch where patch.stock is ripe and patch.class is coop   as green gem
  look patch where patch.stock is ripe and patch.class is defect as red gem
  observe {
    window ahead 9, behind 1, left 5, right 5  # Melting Pot
    show patch as { coop where patch.stock is ripe and patch.class is coop, defect where patch.stock is ripe, floor }
    show gate as { floor }
    show agent.bag
    show agent.brought
    show agent.faced
    show agent.hot
    show other.badge
    show agent.sign
    show other.sign
  }
  metrics { event collected by { coop, defect }  event destroyed by { coop, defect }  event met }
  checks { symmetric agents  expect met == 0 with never(interact) over 10 episodes }
  checks class { require prisoners_dilemma(payoff) }
  define enough                   = 3  # ours: the mixture is then surely of the class that is gathered
  define meets(one, other, class) = other is not one and one.bag[class] > enough and can_meet(one) and can_meet(other)
  policy cooperator "gathers what cooperates, and challenges whoever is nearest" {
    aim beam at agent as other where meets(agent, other, coop) choose interact
    seek patch where patch.class is coop and patch.stock is ripe avoiding patch where patch.class is defect
  }
  policy defector "gathers what defects, and challenges whoever is nearest" {
    aim beam at agent as other where meets(agent, other, defect) choose interact
    seek patch where patch.class is defect and patch.stock is ripe avoiding patch where patch.class is coop
  }
  variant repeated "Two players meet again and again; all resources are back when both are away" {
    set players = 2  set absence = 6  set ending = 0.1  set regrow = 0.02  map "maps/matrix_repeated.txt"  # Melting Pot
    observe { window ahead 3, behind 1, left 2, right 2  hide other.badge }                                # Melting Pot
    schedule walk -> tick -> collect -> aim -> wreck -> meet -> refill -> settle -> grow -> sign -> close
    phase refill { when count(agent) == 0 { each patch { set patch.stock = ripe } } }
  }
}
