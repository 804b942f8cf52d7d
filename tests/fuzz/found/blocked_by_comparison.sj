# `site < 6 & (target != position)`: a condition that folds to one comparison stood without brackets, and nothing was blocked.
sj 1
game found {
  episode 20
  kind grass "."
  kind rock  "#" { blocks agents when not agent.away }
  map { "..#..#"  "#....#"  "......" }
  agents 2 { acts forward, step_left, step_right, backward, stay  moves compass }
  phase start { each agent { send agent to grass } }
  schedule walk
  phase walk { move each agent }
}
