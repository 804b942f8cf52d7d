sj 1
# Cells as values: homes, where one came from, what is carried where; read, compared, sought and sent to.
game cells "Homes and ways back" {
  size most_way : cells = 9
  episode 60
  kind grass "."
  kind wall  "#" { blocks agents }
  kind gate  "g" { field fruit : { none, ripe } = ripe  field last : cell of ground  field visits : 0 .. 9 capped = 0 }
  kind tree  "T" { field fruit : { none, ripe } = ripe  field goal : cell of gate }
  group ground = grass, gate, tree
  group plant = gate, tree
  field best : cell of plant
  map { "g.T.g"
        "..#.."
        "gT..g" }
  agents 4 {
    acts turn_left, turn_right, forward, stay, home, back, swap
    moves relative
    field home   : cell of gate
    field origin : cell of ground
    field aim    by { near, far } : cell of plant
    field way    : 0 .. most_way = 0
    field bag    : 0 .. 9 capped = 0
  }
  phase start {
    match agent with gate { set agent.home = gate }
    each agent as a { send a to ground facing north }
  }
  schedule remember -> walk -> see -> use -> ripen -> travel -> swap -> later -> tick
  phase remember { each agent on ground where agent chose forward { set agent.origin = ground } }
  phase walk { move each agent }
  phase see {
    each agent as a on plant as p {
      set a.aim[near] = p
      when a.home is not nowhere { set a.aim[far] = a.home }
      when p is best { add 1 to a.bag }
      when a.aim[near] is a.aim[far] { add 1 to a.bag }
    }
    each agent as a where a.home is not nowhere {
      set a.way = min(distance(a, a.home), most_way)
      each gate in a.home { add 1 to gate.visits }
      when a.home.fruit is ripe and a.home.row == 0 { give 1 to a }
      when a.home.col > a.col { give 10 to a }
    }
    pick 1 plant as p where p.fruit is ripe and p is not best { set best = p }
    each tree as t { pick 1 gate where gate.visits < 5 { set t.goal = gate } }
    each gate as g { pick 1 agent as v on grass as at in square(1) of g { set g.last = at } }
  }
  phase use {
    each tree where tree.goal is not nowhere { each gate in tree.goal where gate.fruit is none { chance 0.5 { set tree.goal = nowhere } } }
    each agent where agent chose stay and agent.home is not nowhere { set agent.home.fruit = none }
  }
  phase ripen { when best is not nowhere { set best.fruit = ripe } }
  phase travel {
    each agent where agent chose home { send agent to agent.home otherwise stay }
    each agent where agent chose back { send agent to agent.origin facing same otherwise stay }
    each agent on tree as t where agent chose turn_left { send agent to t.goal facing south otherwise stay }
  }
  phase swap {
    match agent as a on ground as ga with agent as b on ground as gb in square(1) of a where a chose swap {
      send a to gb facing same otherwise stay
      send b to ga facing west otherwise stay
    }
  }
  phase later { each agent where agent.bag > 3 { set agent.bag = 0  send agent to agent.home after 2 otherwise stay } }
  observe { window ahead 2, behind 1, left 1, right 1 }
  metrics { mean at_home = count(agent on gate where agent.home is gate)  mean nobody_home = count(agent where agent.home is nowhere) }
  policy homing { seek gate in agent.home  seek gate where gate is not agent.home }
}
