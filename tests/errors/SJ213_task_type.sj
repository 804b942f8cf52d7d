sj 1
game chosen "A task of rewards" {
  episode 5
  task rules { field hue : { red, green }  field price : reward  field friend : different 0 .. 3 }
  kind grass "."
  map { "..." }
  agents 2 { acts stay, forward  moves relative }
  phase start { each agent { send agent to grass } }
  schedule pay -> walk
  phase pay { when hue is red { give 1 to all } }
  phase walk { move each agent }
}
