sj 1
game shifting "Rows that are shifted: a queue, a belt; params as arguments of phases; real draws" {
  param low   : reward      = -1 in -2 .. 0
  param worth : reward      = { empty: 0, box: 2 }
  param luck  : probability = 0.25 in 0 .. 0.5
  episode 10
  kind belt "." { field load by 0 .. 3 : { empty, box } = empty }
  map { ".." }
  agents 2 {
    acts stay, join
    field lately by -1 .. 1 : 0 .. 9 = 2
  }
  field line by 0 .. 2 : agent
  phase start { each agent { send agent to belt } }
  schedule join -> roll(luck, worth) -> roll(2 * luck, worth)
  phase join {
    set line = shift(line, -1, nobody)
    each agent as a { set a.lately = shift(a.lately, 1, a.index) }
    each agent as a where a chose join { give max(a.lately) / 2 + min(worth) to a }
  }
  phase roll(p, table) {
    each belt {
      draw x from low .. 1.5
      chance p { set belt.load = shift(belt.load, 1, box) } otherwise { set belt.load = shift(belt.load, 1, belt.load[3]) }
      give table[belt.load[2]] + x to all
    }
    pick 1 agent as a where a chose join { set line[2] = a }
  }
}
