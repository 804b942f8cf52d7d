sj 1
game constants "What is known when compiled, and what nobody reads" {
  size  full : count       = 3
  param luck : probability = 0.5
  episode 10
  kind grass "."
  kind tree  "T" { field fruit : { none, ripe } = ripe }
  kind pond  "o" { field fish : { none, some } = none }
  map { ".T.T" }
  agents 2 { acts stay, shake }
  phase start { each agent { send agent to grass } }
  schedule rule
  phase rule {
    each pond where pond.fish is some { set pond.fish = none }
    each agent {
      let unread = count(tree where tree.fruit is ripe)
      draw unused from 1 .. 6
      chance 0 { give 1 to agent } otherwise chance luck { give 2 to agent }
      when full * 2 + 1 > 6 and agent chose shake { give 5 to agent } otherwise when 1 > 2 { give 6 to agent }
      when 2 < 1 { give 7 to agent } otherwise { give 8 to agent }
    }
    each tree where not (tree.fruit is none or full < 1) { chance 1 { set tree.fruit = none } }
  }
}
