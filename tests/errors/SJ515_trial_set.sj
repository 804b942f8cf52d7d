sj 1
game counted "A rule that counts the trials itself" {
  episode 3 trials of 10
  kind grass "."
  map { "..." }
  agents 2 { acts stay, forward  moves relative }
  phase start { each agent { send agent to grass } }
  schedule next
  phase next { when step == 5 { set trial = trial + 1 } }
}
