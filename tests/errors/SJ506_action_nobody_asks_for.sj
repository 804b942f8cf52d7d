sj 1
game pond "An action that no rule looks at, and steps that nobody takes" {
  param fish : reward = 1
  episode 10
  kind water "~"
  map { "~~~" }
  agents 2 { acts forward, backward, stay, fish_here, dive }
  phase start { each agent { send agent to water } }
  schedule catch
  phase catch { each agent where agent chose fish_here { give fish to agent } }
}
