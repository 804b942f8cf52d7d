sj 1
game pond "Events that are listed and never counted: one is read by a check, one has words" {
  param fish : reward = 1
  episode 10
  kind water "~"
  map { "~~~" }
  agents 2 { acts forward, stay  moves compass }
  phase start { each agent { send agent to water } }
  schedule swim -> catch
  phase swim { move each agent }
  phase catch { each agent where agent.col == 0 { give fish to agent  tally caught for agent } }
  metrics { event caught  event lost  event seen by { near, far } }
  checks { expect lost == 0 with random over 3 episodes }
}
