sj 1
game real_numbers "Roots, powers, exponentials and logarithms that decide or don't; real fields with a range" {
  size  two  : count  = 2
  param rate : number = 0.3 in 0 .. 1
  param bend : number = 1.5 in 0 .. 3
  param keen : number = 0.7 in -2 .. 2
  param pay  : reward = 1
  episode 30
  kind soil "." {
    field wet  : fraction = 0.5
    field deep : number in -1.5 .. two capped = 0
  }
  map { "...." }
  agents 2 {
    acts stay, work
    field bag   : 0 .. 9 capped = 1
    field trust by agent : probability = 0.5
    field mood  : number in -1 .. 1 capped = 0.25
    field gold  : reward in 0 .. 10 = 1
    field half  : number in -0.5 .. 0.3 = 0.1
    field seen  : reward
  }
  field heat : number in 0 .. 100 = 20
  phase start { each agent { send agent to soil } }
  schedule act -> look_back
  phase act {
    each agent as a {
      add case a chose work { yes: 1, no: 0 } to a.bag
      add case a chose work { yes: 0.3, no: -0.1 } to a.mood
      each agent as b { set a.trust[b] = min(max(a.trust[b] + rate * (case b chose work { yes: 1, no: 0 } - a.trust[b]), 0), 1) }
      chance a.trust[a] ^ 3 { tally trusted for a }
      when a.gold <= 9 { add rate to a.gold }
      let half = a.mood * 0.5
      set a.half = min(half, 0.3)
      add pay * (sqrt(a.bag) + log(a.bag + 1) - exp(-a.bag)) to a.seen
      give a.gold to a
    }
    each agent where agent.bag > 0 { give pay * agent.bag ^ bend to agent }
    each soil { add rate * 0.3 to soil.deep  set soil.wet = max(soil.wet - 0.01, 0) }
    when heat > 1 { set heat = heat * 0.95 + sum(sqrt(agent.gold) over agent) * 0.1 }
  }
  phase look_back {
    each agent as a where a.mood * 0.1 + a.half > 0.05 { tally glad for a }
    each agent as a { chance 1 / (1 + exp(keen * (3 - a.bag))) { tally chosen for a } }
    each agent as a where a.bag ^ two + a.bag ^ 0 > 17 { tally rich for a }
    each agent as a where log(a.bag + 1) * 0.3 + sqrt(a.bag) * 0.1 > 0.7 and (a.bag + 1) ^ bend * 0.1 < 2.7 { tally middling for a }
    each soil where soil.deep + soil.wet * 0.1 > 1.1 { tally soaked }
  }
  observe { window ahead 1, behind 1, left 1, right 1  show agent.mood as { good where agent.mood > 0, bad } }
  metrics { event trusted  event glad  event chosen  event rich  event middling  event soaked  mean warmth = heat }
  checks { always heat <= 100  always all (agent where agent.mood <= 1) }
}
