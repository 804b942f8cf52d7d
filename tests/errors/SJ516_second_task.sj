sj 1
game chosen "Two tasks" {
  episode 5
  task rules { field hue : { red, green }  field price by { red, green } : 0 .. 9 }
  task more { field tone : { dark, light } }
  kind grass "."
  map { "..." }
  agents 2 { acts stay, forward  moves relative }
  phase start { each agent { send agent to grass } }
  schedule pay -> walk
  phase pay { when hue is red { give 1 to all } }
  phase walk { move each agent }
}
