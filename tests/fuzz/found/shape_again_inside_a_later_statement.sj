# The cells around an agent that were looked at before, and again inside a statement for each agent, had their axes in the wrong order.
sj 1
game found "Found" {
  episode 20
  kind grass "."
  kind tree  "T"
  map { "..."  "T.." }
  agents 4 { acts stay }
  shape ray = diamond(2)
  phase start { each agent { send agent to grass } }
  schedule grow
  phase grow {
    pick 1 agent as chosen {
      give max(1 over tree in ray of chosen otherwise 1) to chosen
      each agent {
        first grass in ray of chosen where chosen is not agent { tally seen[2] }
      }
    }
  }
  metrics { event seen by 0 .. 2 }
}
