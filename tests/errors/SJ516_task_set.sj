sj 1
game chosen "A rule that changes the task" {
  episode 5
  task rules { field hue : { red, green }  field price by { red, green } : 0 .. 9 }
  kind grass "."
  map { "..." }
  agents 2 { acts stay, forward  moves relative }
  phase start { each agent { send agent to grass } }
  schedule pay -> walk
  phase pay { set hue = green  set price[red] = 3 }
  phase walk { move each agent }
}
