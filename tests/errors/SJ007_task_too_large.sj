sj 1
game chosen "A task of too many numbers" {
  episode 5
  task rules { field hue : { red, green }  field price by { red, green } : 0 .. 1000000 }
  kind grass "."
  map { "..." }
  agents 2 { acts stay, forward  moves relative }
  phase start { each agent { send agent to grass } }
  schedule pay -> walk
  phase pay { when hue is red and price[red] > 9 { give 1 to all } }
  phase walk { move each agent }
}
