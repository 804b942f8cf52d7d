# `… + 1[..., None]`: the word of an entry stood without brackets.
sj 1
game found {
  param luck : probability = 0.5
  episode 20
  kind grass "."
  field sky by { low, glad, red } : 0 .. 9 = 7
  map { "..."  "..." }
  agents 2 {
    acts forward, stay
    field bag by { low, glad, red } : 0 .. 9 = 1
  }
  phase start {
    each agent { send agent to grass }
    set sky[case 1 > luck { yes: glad, no: red }] = 0
  }
  schedule paint
  phase paint {
    each agent { set agent.bag[case agent chose forward { yes: glad, no: red }] = agent.bag[red] }
  }
}
