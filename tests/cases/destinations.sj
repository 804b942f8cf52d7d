sj 1
game destinations "Sent where it depends on who is sent" {
  episode 10
  kind grass "."
  kind gate  "g" { field team : { red, blue } = red  field owner : agent  glyph "b" with team = blue }
  map { "g..b"  "g..b" }
  agents 2 {
    acts stay, call, push, flee
    field team  : { red, blue } = red
    field calls : 0 .. 3 capped = 0
    field home  : cell of gate
  }
  phase start { each agent { send agent to gate where gate.col == 3 * agent.index facing east } }
  schedule join -> summon -> shove -> flee -> return_home -> go_home -> tick
  phase join {
    each agent on gate {
      set agent.team = gate.team
      set gate.owner = agent
      when agent.home is nowhere { set agent.home = gate }
    }
  }
  phase summon {
    match agent as a with agent as b in line(3) of a where a chose call {
      send b to gate where gate.team is a.team and gate.row != a.row facing same otherwise stay
      add 1 to b.calls
    }
  }
  phase shove {
    match agent as a with first agent as b in line(2) of a where a chose push {
      send a by 1 ahead otherwise stay
      send b by a.calls + 1 a.heading facing west otherwise stay
    }
  }
  phase flee {
    each agent as a where a chose flee { pick 1 gate in square(1) of a { send a by 1 away from gate otherwise stay } }
    each agent as a where a chose stay { pick 1 agent as b where b is not a { send a by 1 toward b otherwise stay } }
  }
  phase return_home {
    each agent where agent.home is not nowhere and agent chose call {
      when agent.home.team is red and distance(agent, agent.home) > 1 { send agent to agent.home facing north otherwise stay }
    }
    each agent { each gate in agent.home { when gate.owner is nobody { set agent.home = nowhere } } }
  }
  phase go_home { each agent where agent.calls > 2 { send agent to agent.home after 2 otherwise stay } }
}
