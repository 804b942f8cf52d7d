sj 1
game dealt "Different values that are no row" {
  episode 5
  kind grass "."
  map { "..." }
  param most : count = 3 in 1 .. 5
  field price by { red, green, blue } : 0 .. 999 = 0
  field share by { red, green, blue } : reward = 0
  agents 2 { acts stay, forward  moves relative }
  phase start { each agent { send agent to grass } }
  schedule deal -> walk
  phase deal { draw x from different 1 .. 2  draw y by { red, green } from different { red: 0.5, green: 0.5 }  draw z by { red, green, blue } from different 0.5 .. 1.5 }
  phase walk { move each agent }
}
