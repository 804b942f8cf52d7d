sj 1
game cells_around "`on` with the name of a cell that a statement around has bound" {
  episode 20
  kind gate  "g" { field visits : 0 .. 90 capped = 0  field busy : 0 .. 1 = 0  field taker : agent }
  kind pond  "p" { field fed : 0 .. 9 capped = 0 }
  kind grass "."
  group shore = grass, pond
  map wraps { "g..g"
              "p..g"
              "..gp" }
  agents 3 { acts forward, turn_left, turn_right, stay, jump  moves relative  field home : cell of gate }
  movers deer 2 "d" { field seen : 0 .. 9 capped = 0 }
  define at(who, place) = who on place
  phase start { each agent { send agent to gate }  each deer { send deer to grass } }
  schedule claim -> walk -> roam -> rule -> back -> leave -> come_back
  phase claim { each agent on gate where agent.home is nowhere { set agent.home = gate } }
  phase walk { move each agent }
  phase roam { move each deer toward gate where not (deer on gate) }
  phase rule {
    each agent { each gate in agent.home { when agent on gate { add 1 to gate.visits } otherwise { give 1 to agent } } }
    each gate {
      set gate.busy = count(agent on gate)
      each agent as a on gate where a chose stay { set gate.taker = a }
      when any (deer on gate) { each agent { when at(agent, gate) or nobody on gate { give 100 to agent } } }
      each deer on gate { add 1 to deer.seen }
    }
    each shore { when any (agent on shore) { each pond in square(1) of shore { add 1 to pond.fed } } }
    each agent on gate { each agent as b where b on gate { give 10 to b } }
  }
  phase back { each agent where agent chose jump { pick 1 gate in agent.home { send agent to gate otherwise stay } } }
  phase leave { each agent on gate where agent chose forward { send agent to gate as other where other.col != gate.col otherwise stay } }
  phase come_back { each deer on gate { send deer to grass } }
  observe {
    window ahead 2, behind 2, left 2, right 2
    show gate as { mine where agent on gate, full where gate.busy == 1, gate }
    show agent.home as { here where agent.home is not nowhere and any (gate in agent.home where agent on gate), away_from_home }
  }
}
