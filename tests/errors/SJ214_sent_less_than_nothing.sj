sj 1
game pond {
  episode 20
  kind shore "."
  map { "...." }
  agents 2 { acts stay, shove }
  phase start { each agent { send agent to shore } }
  schedule rest
  phase rest { each agent where agent chose shove { send agent by 1 - 2 east otherwise stay } }
}
