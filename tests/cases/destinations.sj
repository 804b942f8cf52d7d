sj 1
game destinations "Sent where it depends on who is sent" {
  episode 10
  kind grass "."
  kind gate  "g" { field team : { red, blue } = red  field owner : agent  glyph "b" with team = blue }
  map { "g..b"  "g..b" }
  agents 2 {
    acts stay, call
    field team  : { red, blue } = red
    field calls : 0 .. 3 capped = 0
  }
  phase start { each agent { send agent to gate where gate.col == 3 * agent.index facing east } }
  schedule join -> summon -> go_home -> tick
  phase join { each agent on gate { set agent.team = gate.team  set gate.owner = agent } }
  phase summon {
    match agent as a with agent as b in line(3) of a where a chose call {
      send b to gate where gate.team is a.team and gate.row != a.row facing same otherwise stay
      add 1 to b.calls
    }
  }
  phase go_home { each agent where agent.calls > 2 { send agent to gate as g where g.owner is agent after 2 otherwise stay } }
}
