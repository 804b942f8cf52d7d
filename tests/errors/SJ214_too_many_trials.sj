sj 1
game long "More steps than a number holds" {
  episode 1024 trials of 1000000000
  kind grass "."
  map { "..." }
  agents 1 { acts stay, forward  moves relative }
  phase start { each agent { send agent to grass } }
  schedule walk
  phase walk { move each agent }
}
