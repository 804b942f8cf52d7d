sj 1
game chosen "What is held out depends on a parameter" {
  episode 5
  param high : count = 4 in 0 .. 9
  task rules { field hue : { red, green }  field price by { red, green } : 0 .. 9 }
  hold out dear of rules where price[red] > high
  kind grass "."
  map { "..." }
  agents 2 { acts stay, forward  moves relative }
  phase start { each agent { send agent to grass } }
  schedule pay -> walk
  phase pay { when hue is red and price[red] > 4 { give 1 to all } }
  phase walk { move each agent }
}
