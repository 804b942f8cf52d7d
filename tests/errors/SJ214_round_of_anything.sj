sj 1
game rounding "A whole number near to one that may be anything" {
  param pace  : number = 1.5
  param speed : number = 1.5 in 0 .. 100
  episode 5
  kind grass "."
  map { ".." }
  agents 1 { acts stay  field bag : 0 .. 9 capped = 0 }
  phase start { each agent { send agent to grass } }
  schedule eat
  phase eat { each agent { add round(pace) to agent.bag  add round(speed * agent.bag) to agent.bag  add round(min(max(pace, 0), 9)) to agent.bag } }
}
