sj 1
game begun "A phase at the start that is in the schedule" {
  episode 3
  kind grass "."
  map { "..." }
  agents 2 { acts stay, forward  moves relative }
  phase start { each agent { send agent to grass } }
  phase claim at start { }
  schedule claim -> walk
  phase walk { move each agent }
}
