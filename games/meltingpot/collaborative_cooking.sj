sj 1
game collaborative_cooking "Collaborative Cooking" {
  cite "Agapiou et al. 2022, Melting Pot 2; Carroll et al. 2019; Strouse et al. 2021"
  about summary "Cooks put three tomatoes into a pot, wait, fetch the soup with a dish and deliver it; everybody is paid for every soup."
                "Counters hold one thing each, so that cooks who cannot pass each other can still work together."
  about paradigm "common interest"

  size  players  : count  = 2 in 1 .. 16   # Melting Pot
  size  longest  : steps  = 50             # ours: what an agent sees of a pot has a bound
  param cooking  : steps  = 20 in 0 .. 49  # Melting Pot
  param delivery : reward = 20             # Melting Pot: to everybody, for every soup
  param pause    : steps  = 1 in 0 .. 100  # Melting Pot: a cook who interacts misses one step before the next time
  episode 1000                             # Melting Pot
  kind floor   "."
  kind start   "P"
  kind counter "#" {
    blocks agents
    field item   : { none, tomato, dish, soup } = none
    field supply : { single, endless } = single
    glyph "O" with item = tomato with supply = endless  glyph "D" with item = dish with supply = endless  glyph "s" with item = soup
  }
  kind pot     "C" {
    blocks agents
    field tomatoes : 0 .. 3 capped = 0  glyph "3" with tomatoes = 3
    field heat     : 0 .. longest = 0
    field bringers : set of agent
  }
  kind hatch   "T" { blocks agents }
  map "maps/cooking_cramped.txt"
  agents players {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, interact
    moves relative
    field hand : { none, tomato, dish, soup } = none
    timer cooling  forbid interact when agent.cooling > 0
  }
  shape reach = line(1)
  define fits(who, place)  = who.hand is tomato and place.tomatoes < 3
  define pours(who, place) = who.hand is dish and place.tomatoes == 3 and place.heat > cooking

  phase start { each agent { send agent to start } }
  schedule walk -> pass -> load -> fill -> serve -> simmer -> tick -> cool
  phase walk { move each agent }
  phase pass {  # of several cooks at one counter, one uses it in a step: whoever comes first, even with nothing to exchange
    each agent where agent chose interact { mark reach of agent }
    match agent as cook with counter in reach of cook where cook chose interact {
      when cook.hand is none and counter.item is not none {
        set cook.hand = counter.item  when counter.supply is single { set counter.item = none }
      } otherwise when cook.hand is not none and counter.item is none {
        set counter.item = cook.hand  set cook.hand = none  tally passed for cook
      }
    }
  }
  phase load {
    match agent as cook with pot in reach of cook where cook chose interact and pours(cook, pot) {
      set pot.tomatoes = 0  set pot.heat = 0  set cook.hand = soup  tally poured for cook
    }
    each agent as cook where cook chose interact { first pot in reach of cook where fits(cook, pot) { add cook to pot.bringers } }
  }
  phase fill {  # on these maps, no more than two cooks can reach a pot
    each pot where pot.tomatoes < 2 {
      pick 2 agent as cook in pot.bringers { set cook.hand = none  add 1 to pot.tomatoes  tally potted for cook }
    }
    each pot where pot.tomatoes == 2 {
      pick 1 agent as cook in pot.bringers { set cook.hand = none  add 1 to pot.tomatoes  tally potted for cook }
    }
    each pot { set pot.bringers = nobody }
  }
  phase serve {
    each agent as cook where cook chose interact and cook.hand is soup {
      first hatch in reach of cook { set cook.hand = none  give delivery to all  tally delivered for cook }
    }
  }
  phase simmer {  # Melting Pot: the soup can be poured cooking + 1 steps after the third tomato
    each pot where pot.tomatoes == 3 and pot.heat <= cooking { set pot.heat = pot.heat + 1 }
  }
  phase cool { each agent where agent chose interact { set agent.cooling = pause } }
  look counter where counter.supply is endless as "#94703f" table
  look counter where counter.item is tomato    as red apple
  look counter where counter.item is dish      as white plate
  look counter where counter.item is soup      as orange plate
  look pot                                     as table
  look pot                                     as pot

  observe {
    window ahead 3, behind 1, left 2, right 2  # Melting Pot: 5 x 5
    show start as { floor }
    show agent.hand  show other.hand  show other.index  # Melting Pot: each cook has a colour of its own
    show pot.tomatoes as { three where pot.tomatoes == 3, two where pot.tomatoes == 2, one where pot.tomatoes == 1, empty }
    hide pot.bringers
    show pot.heat as {                         # Melting Pot: a bar of ten marks
      ready where pot.heat > cooking, all_ten where pot.heat == cooking, nine where 10 * pot.heat >= 9 * cooking,
      eight where 10 * pot.heat >= 8 * cooking, seven where 10 * pot.heat >= 7 * cooking, six where 10 * pot.heat >= 6 * cooking,
      half where 10 * pot.heat >= 5 * cooking, four where 10 * pot.heat >= 4 * cooking, thrice where 10 * pot.heat >= 3 * cooking,
      twice where 10 * pot.heat >= 2 * cooking, once_up where 10 * pot.heat >= cooking, cold }
  }
  metrics { event delivered  event potted  event poured  event passed }
  checks {
    symmetric agents
    always count(pot where pot.heat > 0 and pot.tomatoes < 3) == 0
    always count(counter where counter.supply is endless and counter.item is none) == 0
    expect delivered == 0 and potted == 0 with never(interact) over 5 episodes
  }
  define full = count(pot where pot.tomatoes == 3)
  policy cook "does whatever comes next, where one cook can reach everything" {
    aim reach at hatch where agent.hand is soup choose interact
    aim reach at pot where fits(agent, pot) or pours(agent, pot) choose interact
    aim reach at counter where agent.hand is none and counter.item is dish and full > count(agent as other where other.hand is dish)
        choose interact
    aim reach at counter where agent.hand is none and counter.item is tomato and full < count(pot) choose interact
    aim reach at counter where agent.hand is tomato and counter.item is none and full == count(pot) choose interact
  }
  variant asymmetric "two rooms, one near the tomatoes and one near the hatch" { map "maps/cooking_asymmetric.txt" }
  variant circuit "a round walk, or tomatoes passed over the middle" { map "maps/cooking_circuit.txt" }
  variant crowded "nine cooks, of whom chance sends some to either side" { map "maps/cooking_crowded.txt"  set players = 9 }
  variant figure_eight "six cooks in narrow lanes" { map "maps/cooking_figure_eight.txt"  set players = 6 }
  variant forced "a room with the stores and a room with the pots: neither cook can do anything alone" { map "maps/cooking_forced.txt" }
  variant ring "a ring that all walk one way round, or are in each other's way" { map "maps/cooking_ring.txt" }
}
