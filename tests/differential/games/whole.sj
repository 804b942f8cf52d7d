sj 1
game whole "Whole numbers: `quotient`, `round`, weighted numbers; `any` and `all`; `step` and defines that are shown" {
  param scale : number      = 1.5 in -4 .. 4
  param odds  : probability = 0.2 in 0 .. 0.5
  param steep by { low, high } : number = { low: 0.25, otherwise: -3.5 } in -4 .. 4
  param one : reward = 1
  episode 60
  kind grass "."
  kind soil  "s" { field level : { low, high } = low  field store : -9 .. 9 capped = 0 }
  map { "..s."  "ss.s" }
  agents 3 {
    acts turn_left, turn_right, forward, stay, dig
    moves relative
    field bag  : -9 .. 9 capped = 0
    field luck : 0 .. 9 = 0
    blocks pile
  }
  shape pile = line(2)
  phase start { each agent { send agent to grass facing east } }
  schedule walk -> dig -> rest
  phase walk { move each agent }
  phase dig {
    draw some from { 3: odds, 0: 0.5, 7: 1 - odds - 0.5 }
    each agent on soil where agent chose dig {
      draw many from { 9: odds, 2: 1 - odds }
      add many - some to soil.store
      add round(scale * some) to agent.bag
      set agent.luck = max(quotient(many + agent.bag, 2), 0) % 10
    }
    each soil { when soil.store > 2 { set soil.level = high } otherwise { set soil.level = low } }
  }
  phase rest {
    each agent as a {
      give one * (quotient(a.bag, -2) + quotient(a.bag, 3) * 10) to a
      give round(a.bag / 2) + round(steep[low] * a.luck) to a
      when any (agent as b in pile of a where b.bag > a.bag) { give 100 to a }
      when all (soil in disc(1) of a where soil.store >= a.bag) { give 1000 to a }
      when not any (soil in square(1) of a) { tally alone for a }
    }
    when all (soil where soil.level is high) or all (agent where agent.luck > 3) { end }
  }
  define rich(who) = who.bag > 2
  define some_rich = any (agent where rich(agent))
  define fifths    = quotient(step, 5)
  define least     = min(soil.store over soil)
  define size_of   = round(max(scale, 0) * fifths)
  define mood      = case some_rich { yes: high, no: low }
  observe {
    window ahead 2, behind 1, left 1, right 1
    show step  show fifths when agent.bag > 0  show some_rich  show mood
    show size_of  show least as { dug where least < 0, full where least > 3, some }
  }
  metrics { event alone  mean half = quotient(sum(agent.bag over agent), 2) }
}
