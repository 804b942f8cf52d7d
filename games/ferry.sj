sj 1
game ferry "Ferry to a Market that Remembers" {
  cite "Cournot 1838, for sellers whose supply sets the price of all"
  about summary "Farmers take what they grow across a river, by a ferry that goes round and round. The market remembers the sales of"
                "the last days, and each lowers the price for everybody: who sells at once spoils it for all."
  about our_paradigm "commons"      # ours: the price is shared, and wears out by use
  about our_long_term_impact "yes"  # ours: for as long as the market remembers
  about our_multi_task "yes"        # ours: to harvest, to cross and to sell are tasks of their own

  size  players  : count = 4 in 2 .. 8     # ours: more than the market feeds well
  size  basket   : count = 4 in 1 .. 9     # ours: what one can carry
  size  crossing : steps = 4 in 1 .. 20    # ours: about as long as the ferry takes
  param length   : steps = 500             # ours: fifty days
  param growing  : steps = 3 in 1 .. 99    # ours: until a plot bears again
  param day      : steps = 10 in 1 .. 100  # ours: about as long as the boat takes round

  param price by 0 .. 9 : reward = { 0: 10, 1: 9, 2: 8, 3: 7, 4: 6, 5: 5, 6: 4, 7: 3, 8: 2, 9: 1 }  # ours: by sales that are remembered

  param enough : count = 4 in 0 .. 9  # ours: from so many sales on a cooperator keeps its goods
  episode length

  kind path  "."
  kind farm  "f" { field crop : { ripe, none } = ripe  timer rest }
  kind stall "s"
  kind wall  "#" { blocks agents, boat }
  kind lane  "r" {
    field way : { north, east, south, west } = east
    glyph "l" with way = west  glyph "u" with way = north  glyph "d" with way = south  blocks agents
  }
  kind dock  "D" { field across : cell of dock  blocks boat }
  map "maps/ferry.txt"
  look farm where farm.crop is ripe as "#c9a227" bush
  look agent where agent.load > 0   with crate
  look lane where lane.way is east  as "#8fc1e6" water
  look lane where lane.way is west  as "#2f5f8f" water
  look lane where lane.way is north as "#c9e4f5" water
  look lane where lane.way is south as "#15324f" water

  agents players {
    acts forward, backward, step_left, step_right, stay, board, sell
    moves compass
    field home : cell of farm  field lands : cell of dock  field load : 0 .. basket capped = 0
  }
  movers boat 1 "b"
  field sold by 0 .. 4 : 0 .. 50 capped = 0  # ours: today, yesterday, …; more than can be grown in a day

  define docked(d) = any (boat where distance(boat, d) <= 1)
  define sales     = min(sum(sold), 9)  # ours: as far as there are prices

  phase start {
    each agent { send agent to farm }
    each boat { send boat to lane }
    each dock as d { pick 1 dock as e where e.row == d.row and e is not d { set d.across = e } }
  }
  schedule tick -> settle -> walk -> sail -> embark -> land -> ripen -> harvest -> sell -> remember

  phase settle {
    each agent on farm where agent.home is nowhere { set agent.home = farm }
    each agent on dock { set agent.lands = nowhere }
  }
  phase walk { move each agent }
  phase sail { move each boat on lane along lane.way }
  phase embark { each agent on dock where agent chose board and docked(dock) { set agent.lands = dock.across  tally crossed for agent } }
  phase land { each agent where agent.lands is not nowhere { send agent to agent.lands after crossing facing same otherwise stay } }
  phase ripen { each farm where farm.crop is none and farm.rest == 0 { set farm.crop = ripe } }
  phase harvest {
    each agent where agent.load < basket {
      each farm in agent.home where farm.crop is ripe and distance(agent, farm) == 0 {
        add 1 to agent.load  set farm.crop = none by lot
        set farm.rest = growing by lot  tally grown for agent
      }
    }
  }
  phase sell {
    each agent on stall where agent chose sell and agent.load > 0 {
      give price[sales] to agent  add -1 to agent.load
      add 1 to sold[0]  tally sold_ for agent
    }
  }
  phase remember { when step % day == day - 1 { set sold = shift(sold, 1, 0) } }

  observe {
    window ahead 4, behind 4, left 4, right 4  # ours: a bank
    show farm.crop as { mine where agent.home is farm and farm.crop is ripe, ripe where farm.crop is ripe, none }
    show agent.load  show other.load  show sales
    hide lane.way  hide dock.across
  }
  metrics { event crossed  event grown  event sold_  mean remembered = sum(sold)  final busiest_day = max(sold) }
  checks {
    symmetric agents
    require price[0] > price[9]
    always sold_ <= grown
    expect sold_ > 0 with cooperator over 3 episodes
    expect sold_ == 0 with never(sell) over 3 episodes
  }
  define goes(a) = case a on stall or a.col > 8 { yes: a.load == 0, no: a.load == basket }  # ours: to the other bank; 8 is in the river
  policy cooperator "sells while the market remembers little" {
    when agent on stall and agent.load > 0 and sales < enough choose sell
    when agent on dock and goes(agent) choose board
    seek stall where agent.load > 0 and nobody on stall
    seek dock where goes(agent)
    seek farm where agent.home is farm
  }
  policy defector "sells whatever it has, at once" {
    when agent on stall and agent.load > 0 choose sell
    when agent on dock and goes(agent) choose board
    seek stall where agent.load > 0 and nobody on stall
    seek dock where goes(agent)
    seek farm where agent.home is farm
  }
  scenario newcomer "a newcomer among those who hold back" { slots 1 focal  slots players - 1 policy cooperator }
  scenario residents "residents meet one who floods the market" { slots players - 1 focal  slots 1 policy defector }
}
