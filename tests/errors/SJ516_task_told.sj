sj 1
game chosen "What agents may do tells the task" {
  episode 5
  task rules { field hue : { red, green }  field price by { red, green } : 0 .. 9 }
  kind grass "."
  map { "..." }
  agents 2 { acts stay, forward  moves relative  forbid forward when price[hue] > 4 }
  phase start { each agent { send agent to grass } }
  schedule pay -> walk
  phase pay { when hue is red { give 1 to all } }
  phase walk { move each agent }
}
