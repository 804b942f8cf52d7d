# The state has room for the marks of a `mark` that is never reached, and the step returned fewer.
sj 1
game found {
  episode 20
  kind grass "."
  kind pond  "O"
  map { "..."  "..." }
  agents 2 { acts forward, zap, stay }
  phase start { each agent { send agent to grass } }
  schedule glance
  phase glance {
    each agent where agent chose zap { mark line(2) of agent }
    each agent on pond { mark disc(1) of agent }
  }
}
