sj 1
game ends "A phase at another moment than the start" {
  episode 3
  kind grass "."
  map { "..." }
  agents 2 { acts stay, forward  moves relative }
  phase start at dawn { each agent { send agent to grass } }
  phase claim at end_of_day { }
  schedule walk
  phase walk { move each agent }
}
