sj 1
# Where one is sent depends on who is sent, on the sentence around it, and on a value drawn for it.
game own_destinations "Teams with gates of their own" {
  param hard : probability = 0.5
  episode 60
  kind grass "."
  kind gate  "g" { field team : { red, blue } = red  field owner : agent  glyph "b" with team = blue }
  kind nest  "n" { field number : 0 .. 3 = 0  glyph "1" with number = 1  glyph "2" with number = 2  glyph "3" with number = 3 }
  map { "gg.bb"
        "n123g"
        ".b..." }
  agents 4 {
    acts turn_left, turn_right, forward, stay, zap
    moves relative
    field team : { red, blue } = blue
    field hits : 0 .. 9 capped = 0
  }
  phase start { each agent { send agent to nest where nest.number == agent.index } }
  schedule walk -> join -> shoot -> drift -> back -> tick -> claim
  phase walk { move each agent }
  phase join { each agent on gate { set agent.team = gate.team } }
  phase shoot {
    match agent as a with first agent as hit in line(3) of a where a chose zap {
      send hit to gate where gate.team is a.team and gate.row != hit.row facing south otherwise stay
      add 1 to hit.hits
    }
  }
  phase drift {
    each agent where agent.index < 2 {
      let side = case agent.hits { 0: agent.team, otherwise: red }
      chance hard { send agent to gate where gate.team is side and nobody on gate facing same otherwise stay }
    }
    each agent as a where a.index == 2 { send a to nest where nest.number > a.hits otherwise stay }
    pick 1 agent as b where b.index == 3 {
      draw most from 0 .. 3
      send b to nest where nest.number > b.hits - most and nest.number <= most otherwise stay
    }
  }
  phase back {
    each agent where agent.hits > 1 {
      set agent.hits = 0
      send agent to gate where gate.team is agent.team or gate.owner is agent after agent.index facing north otherwise stay
    }
  }
  phase claim { each agent on gate where gate.owner is nobody { set gate.owner = agent } }
  observe { window ahead 2, behind 1, left 1, right 1 }
  metrics { mean red_ones = count(agent where agent.team is red) }
}
