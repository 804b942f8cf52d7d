# An entry set in a branch that is taken for all or for none: one value was combined with a row of each cell.
sj 1
game found {
  episode 20
  kind grass "."
  kind rock  "T" { field fans by { low, red } : 0 .. 3 = 2 }
  map { "..T"  "..T" }
  agents 2 { acts forward, stay }
  phase start { each agent { send agent to grass } }
  schedule paint
  phase paint {
    pick 1 agent where agent chose forward { give 1 to agent }
    otherwise {
      each rock { set rock.fans[highest(rock.fans)] = 1 }
    }
  }
}
