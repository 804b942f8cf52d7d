sj 1
game lots "One winner by lot" {
  episode 30
  kind grass "."
  kind tree  "T" { field taker : agent  field bid : 0 .. 9 = 0  field seen : { none, low, high } = none }
  map { "..T."  "T..."  ".TT." }
  field king   : agent
  field pot    : 0 .. 20 = 0
  field prices by { left, right } : 0 .. 9 = 0
  field names  by 1 .. 3 : agent
  agents 4 {
    acts turn_left, forward, stay, grab, bid(0 .. 3)
    field rival : agent
    field luck  : reward = 0
    field trust by agent : 0 .. 9 = 1
    field hands by { left, right } : 0 .. 9 = 0
    field met   by { near, far } : set of agent
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
    each agent where agent chose grab { set king = agent by lot  set names[2] = agent by lot }
    each tree as t { each agent as a in disc(2) of t { set t.taker = nobody by lot  set a.luck = t.col * 0.25 by lot } }
    each agent as a {
      each agent as b in square(2) of a {
        set b.trust[a] = a.index by lot
        set a.trust[b] = a.index + 5 by lot
        set b.hands = a.hands by lot
        when a chose grab { set b.hands = a.index by lot  set b.met = a.met by lot }
        when a chose forward { set b.met = nobody by lot  set prices = a.hands by lot }
        when a.index > b.index { set names[1 + a.hands[left] % 3] = b by lot }
      }
    }
    each agent as a where a chose stay { set prices = 3 by lot  set king = nobody by lot }
  }
  phase rest { each tree where tree.taker is not nobody { give 1 to tree.taker  set tree.taker = nobody } }
}
