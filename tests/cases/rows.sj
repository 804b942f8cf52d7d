sj 1
game rows "Rows of numbers by word, tables of numbers and of words" {
  param worth  : reward = { raw: 1, cut: 3 }
  param next   : word   = { raw: cut, cut: raw }
  param payoff : reward = { raw: { raw: 1, cut: 0 }, cut: { raw: 2, cut: 3 } }
  episode 10
  kind grass "."
  map { ".." }
  agents 2 {
    acts stay, sell, change
    field bag by { raw, cut } : 0 .. 9 capped = 2
  }
  phase start { each agent { send agent to grass } }
  schedule trade(raw) -> trade(cut) -> mingle
  phase trade(what) {
    each agent where agent chose sell and agent.bag[what] > 0 {
      give worth[what] * agent.bag[what] to agent
      set agent.bag[what] = 0
    }
    each agent where agent chose change { add 1 to agent.bag[next[what]] }
  }
  phase mingle {
    each agent as one {
      each agent as two where two is not one and sum(one.bag) > 0 and sum(two.bag) > 0 {
        give payoff[mix(one.bag)][mix(two.bag)] to one
        tally seen[lowest(two.bag)] for one
      }
    }
  }
  observe { window ahead 1, behind 0, left 0, right 0  show agent.bag }
  metrics { event seen by { raw, cut }  final held = sum(agent.bag[cut] over agent) }
}
