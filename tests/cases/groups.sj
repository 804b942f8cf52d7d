sj 1
game groups "Sets of agents, kinds in groups, fields of the world" {
  field turns : 0 .. 99 capped = 0
  episode 10
  kind stone "o" { field lifters : set of agent }
  kind rock  "O" { field lifters : set of agent }
  kind grass "."
  group heavy = stone, rock
  map { ".oO." }
  agents 2 {
    acts stay, lift, join
    field club : set of agent
  }
  phase start { each agent { send agent to grass } }
  schedule lift -> share
  phase lift {
    add 1 to turns
    each agent as a where a chose lift { each heavy in square(1) of a { add a to heavy.lifters } }
    each agent as a where a chose join { each agent as b in square(1) of a { add a to b.club } }
  }
  phase share {
    each heavy where count(agent in heavy.lifters) == 2 { give 3 to heavy.lifters  set heavy.lifters = nobody }
    when turns > 5 { each agent as a { each agent as b in a.club { give 1 to b } } }
    give -0.25 to all
  }
}
