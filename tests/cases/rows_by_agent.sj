sj 1
game rows_by_agent "Rows by agent and by numbers: memory, tit for tat, standing, tastes, a queue" {
  size players : count = 3 in 1 .. 8
  param taste by agent : reward = { 0: { helped: 2, refused: 0 }, otherwise: { helped: 0, refused: 1 } }
  param wage by { farmer, cleaner } : reward = { farmer: 2, otherwise: 1 }
  param gift by 0 .. 3 : reward = { 0: 0, 1 .. 2: 1, 3: 2 }
  episode 10
  kind grass "."
  kind shop  "S" { field owed by agent : 0 .. 9 capped = 0 }
  map { "..S."  "...S" }
  agents players {
    acts forward, turn_left, stay, help
    moves relative
    field last  by agent : { helped, refused } = helped
    field trust by agent : 0 .. 5 = 3
    field role  : { farmer, cleaner } = farmer
  }
  field standing by agent : 0 .. 9 capped = 5
  field line     by 0 .. 2 : agent
  phase start { each agent { send agent to grass  when agent.index == 0 { set agent.role = cleaner } } }
  schedule walk -> answer -> remember -> serve
  phase walk { move each agent }
  phase answer {
    each agent as a where a chose help {
      each agent as b in square(1) of a where a.last[b] is helped and b.trust[a] > 1 {
        give taste[b][a.last[b]] + wage[b.role] to b
        give gift[min(a.trust[b], 3)] to a
        add 1 to standing[a]
      }
      each shop in square(1) of a { add 2 to shop.owed[a] }
    }
  }
  phase remember {
    each agent as a {
      each agent as b in square(1) of a {
        set a.last[b] = case b chose help { yes: helped, no: refused }
        when b chose help and a.trust[b] < 5 { add 1 to a.trust[b] }
      }
      each agent as b where a.trust[b] > 0 and b chose forward { set a.trust[b] = b.trust[a] }
      add -1 to standing[a]
    }
    match agent as a with agent as b in square(2) of a { tally met[b] for a }
  }
  phase serve {
    when line[0] is not nobody { give 1 to line[0] }
    pick 1 agent as a where a.trust[a] == 3 and sum(b.trust[a] over agent as b) > 5 { set line[count(agent) % 3] = a }
  }
  observe {
    window ahead 1, behind 0, left 1, right 1
    show agent.trust  show standing
    show other.last as { kind_one where agent.last[other] is helped, other_one }
  }
  metrics { event met by agent  mean trusted = count(agent as a where standing[a] > 4) }
}
