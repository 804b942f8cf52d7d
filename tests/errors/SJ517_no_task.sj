sj 1
game chosen "Tasks to train on where there are none" {
  episode 5
  train on 4 of rules seed 0
  kind grass "."
  map { "..." }
  agents 2 { acts stay, forward  moves relative }
  phase start { each agent { send agent to grass } }
  schedule pay -> walk
  phase pay { give 1 to all }
  phase walk { move each agent }
}
