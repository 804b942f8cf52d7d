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
    forbid forward, work when agent.tired > 0
    forbid all when night > 2
  }
  phase start { each agent { send agent to fire } }
  schedule tick -> walk -> work
  phase walk { move each agent where agent.tired == 0 }
  phase work {
    each agent on fire where agent chose work {
      draw rest from rest_lo .. rest_hi
      set agent.tired = rest
      set fire.left = rest_hi
    }
    when step == 4 { set night = 3 }
  }
  observe { window ahead 1, behind 0, left 0, right 0  show agent.tired  show night }
  checks { require rest_lo <= rest_hi }
}
