sj 1
game timers "What falls by one at each tick, and what it forbids" {
  param rest_lo : steps = 2 in 0 .. 9
  param rest_hi : steps = 5 in 0 .. 9
  episode 10
  kind fire "f" { timer left }
  map { "ff" }
  timer night
  agents 2 {
    acts turn_left, forward, stay, work
    moves compass
    timer tired
    timer due by { early, late }
    timer debt by agent
    forbid forward, work when agent.tired > 0
    forbid all when night > 2 or agent.debt[agent] > 6
  }
  phase start { each agent { send agent to fire } }
  schedule tick -> walk -> work
  phase walk { move each agent where agent.tired == 0 }
  phase work {
    each agent on fire where agent chose work {
      draw rest from rest_lo .. rest_hi
      set agent.tired = rest
      set agent.due[early] = rest
      set agent.due[late] = rest_hi
      set agent.debt[agent] = agent.debt[agent] + rest_lo
      set fire.left = rest_hi
    }
    when step == 4 { set night = 3 }
  }
  observe { window ahead 1, behind 0, left 0, right 0  show agent.tired  show agent.due  show night }
  checks { require rest_lo <= rest_hi }
}
