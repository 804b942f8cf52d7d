# Picking from one large set for each of many cells.
sj 1
game base {
  episode 30
  kind rock "."
  kind gate "#"
  field king : set of agent
  map { "........"  "........"  "........"  "........"  "........"  ".......#" }
  agents 40 { acts stay }
  shape cone { "x"  "^" }
  phase start { each agent { send agent to rock } }
  schedule crown -> trade
  phase crown { each agent { chance 0.5 { add agent to king } } }
  phase trade {
    each rock {
      pick 1 agent as chosen in king {
        first agent in cone of chosen { tally hits }
      }
    }
  }
  metrics { event hits }
}
