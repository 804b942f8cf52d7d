sj 1
game chosen "More tasks to train on than leave any" {
  episode 5
  task rules { field hue : { red, green } }
  train on 2 of rules seed 0
  kind grass "."
  map { "..." }
  agents 2 { acts stay, forward  moves relative }
  phase start { each agent { send agent to grass } }
  schedule pay -> walk
  phase pay { when hue is red { give 1 to all } }
  phase walk { move each agent }
}
