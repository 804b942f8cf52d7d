sj 1
game chosen "A task that is kept anyway" {
  episode 2 trials of 5 { keep hue, price }
  task rules { field hue : { red, green }  field price by { red, green } : 0 .. 9 }
  kind grass "."
  map { "..." }
  agents 2 { acts stay, forward  moves relative }
  phase start { each agent { send agent to grass } }
  schedule pay -> walk
  phase pay { when hue is red { give 1 to all } }
  phase walk { move each agent }
}
