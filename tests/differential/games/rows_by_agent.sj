sj 1
game rows_by_agent "Rows by agent, by role and by numbers, written in every way and read across" {
  size players : count = 3 in 1 .. 8
  param taste by agent : reward = { 0: 2, otherwise: 0.5 }
  param wage by { farmer, cleaner } : reward = { farmer: 2, otherwise: 1 }
  param mixed by agent : reward = { none: 1, ripe: 2 }
  param steps_of by 0 .. 3 : count = { 0: 1, 1 .. 2: 4, 3: 2 }
  episode 20
  kind grass "."
  kind tree  "T" { field fruit : { none, ripe } = ripe  field paid by agent : 0 .. 9 capped = 0 }
  map { "...."  "TTTT" }
  agents players {
    acts turn_left, turn_right, forward, stay, zap
    moves relative
    field trust by agent : 0 .. 5 = 3
    field role  : { farmer, cleaner } = farmer
    field last  by agent : { stay_, zap_ } = stay_
    field slot  by 0 .. 3 : 0 .. 9 capped = 1
    field spot  : 0 .. 3 = 0
  }
  field standing by agent : 0 .. 9 capped = 5
  field line     by 0 .. 2 : agent
  phase start { each agent { send agent to grass } }
  schedule walk -> rule -> learn
  phase walk { move each agent }
  phase rule {
    each agent as a {
      each agent as b where b is not a {
        set a.last[b] = case b chose zap { yes: zap_, no: stay_ }
        when a.trust[b] < 5 and b chose zap { set a.trust[b] = a.trust[b] + 1 }
        give taste[b] to a
        give wage[a.role] to b
        give mixed[a][ripe] to b
      }
    }
    each agent as a { add 1 to a.slot[a.spot]  when a.spot < 3 { set a.spot = a.spot + 1 } }
    each agent as a { each agent as b in disc(1) of a { add 1 to standing[b]  add -1 to standing[a] } }
    each tree { each agent as a in disc(1) of tree { add steps_of[a.spot] to tree.paid[a] } }
  }
  phase learn {
    each agent as a { each agent as b in disc(2) of a where b.trust[a] > 3 { set a.last[b] = zap_ } }
    each agent as a where sum(a.trust[b] over agent as b) > 4 and count(agent as b where b.trust[a] > 2) > 0 { give 1 to a }
    pick 1 agent as a { set line[0] = a }
    when line[0] is not nobody { give 3 to line[0]  set line[1] = line[0] }
    match agent as a with agent as b in disc(2) of a { set a.trust[b] = 0  set b.trust[a] = 1 }
  }
  observe {
    window ahead 1, behind 0, left 1, right 1

    show agent.trust
    show standing
    show other.trust as { kind_ where other.trust[agent] > 2, wary where agent.last[other] is zap_, hostile }
  }
}
