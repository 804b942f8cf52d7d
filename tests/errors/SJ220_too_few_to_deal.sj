sj 1
game dealt "Fewer values than entries" {
  episode 5
  kind grass "."
  map { "..." }
  param most : count = 3 in 1 .. 5
  field price by { red, green, blue } : 0 .. 999 = 0
  field share by { red, green, blue } : reward = 0
  agents 2 { acts stay, forward  moves relative }
  phase start { each agent { send agent to grass } }
  schedule deal -> walk
  phase deal { draw x by { red, green, blue } from different 1 .. 2  set price = x  draw y by agent from different { red } }
  phase walk { move each agent }
}
