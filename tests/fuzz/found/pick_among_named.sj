# The number of the one picked among agents in braces was its place in the braces, not the agent's.
sj 1
game found {
  episode 20
  kind grass "."
  map { "...."  "...." }
  agents 3 {
    acts forward, stay
    field bag : 0 .. 9 capped = 0
  }
  phase start { each agent { send agent to grass } }
  schedule alone -> pairs
  phase alone { each agent { pick 1 agent as one in { agent } { add 1 to one.bag } } }
  phase pairs {
    match agent as a with agent as b {
      pick 1 agent as one in { b, a } { chance 0.5 { give 1 to one } }
      pick 2 agent as one in { b, a } where one chose forward { give 0.25 to one }
    }
  }
}
