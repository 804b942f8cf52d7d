# Whether agents may move was looked up in a table without entries, as the map has no gate.
sj 1
game found {
  episode 20
  kind grass "."
  kind gate  "T" { field fruit : 0 .. 3 = 1 }
  map { "..."  "..." }
  agents 3 { acts forward, turn_left, stay }
  phase start { each agent { send agent to grass } }
  schedule walk -> push -> pay
  phase walk { move each agent }
  phase push { move each agent on gate where gate.fruit > 0 }
  phase pay { each agent where agent.moved { give 1 to agent } }
}
