sj 1
game lots "One winner by lot" {
  episode 30
  kind grass "."
  kind tree  "T" { field taker : agent  field bid : 0 .. 9 = 0  field seen : { none, low, high } = none }
  map { "..T."  "T..."  ".TT." }
  field king : agent
  field pot  : 0 .. 20 = 0
  agents 4 {
    acts turn_left, forward, stay, grab, bid(0 .. 3)
    field rival : agent
    field luck  : reward = 0
  }
  phase start { each agent { send agent to grass } }
  schedule walk -> grab -> rest
  phase walk { move each agent where not (agent chose grab) }
  phase grab {
    each agent as a where a chose grab or a chose bid {
      each tree in disc(2) of a { set tree.taker = a by lot }
      each agent as b in square(2) of a { set b.rival = a by lot  set b.luck = a.index * 0.5 + 1 by lot }
    }
    each agent as a where a chose bid {
      each tree in square(1) of a { set tree.bid = a.bid + a.index by lot  set tree.seen = case a.bid { 0: low, otherwise: high } by lot }
      set pot = a.bid * 3 by lot
    }
    each agent where agent chose grab { set king = agent by lot }
  }
  phase rest { each tree where tree.taker is not nobody { give 1 to tree.taker  set tree.taker = nobody } }
}
