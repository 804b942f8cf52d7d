sj 1
game beams "A drawn shape that walls stop: cells in it, the first of each lane, marks" {
  episode 10
  kind grass "."
  kind wall  "#" { blocks agents, beam }
  kind ore   "o" { field left : { none, some } = some }
  map {
    "..o"
    ".#o"
  }
  agents 2 {
    acts stay, dig, shout
    field heard : 0 .. 9 capped = 0
  }
  shape beam { ".x."
               "xxx"
               ".^." }
  phase start { each agent { send agent to grass } }
  schedule work
  phase work {
    each agent as digger where digger chose dig {
      mark beam of digger
      first ore in beam of digger where ore.left is some { set ore.left = none  give 1 to digger }
      when count(ore in beam of digger where ore.left is some) == 0 { tally missed for digger }
    }
    each agent as one where one chose shout {
      each agent as two in beam of one { add 1 to two.heard }
    }
  }
  observe { window ahead 2, behind 1, left 1, right 1 }
  metrics { event missed }
}
