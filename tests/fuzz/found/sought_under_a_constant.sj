# A policy that seeks an agent held by a field, under a condition that is known beforehand, failed when it was compiled.
sj 1
game base {
  episode 20
  kind rock "."
  field king : agent
  map { "..."  "..." }
  agents 2 { acts stay, step_right }
  phase start { each agent { send agent to rock } }
  schedule walk
  phase walk { move each agent }
  policy shy { aim diamond(2) at agent as other in king where other.away choose step_right }
}
