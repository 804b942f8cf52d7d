sj 1
game picking "Some members at random: of all cells, and for each agent of those around it" {
  param many : count = 2 in 0 .. 4
  episode 10
  kind pond "p" { field fish : { none, some } = some }
  map { "pppp" }
  agents 2 { acts stay, cast }
  phase start { each agent { send agent to pond } }
  schedule dry -> catch
  phase dry { pick many pond where pond.fish is some { set pond.fish = none } otherwise { tally empty } }
  phase catch {
    each agent where agent chose cast {
      pick 1 pond in square(1) of agent where pond.fish is some { give 1 to agent }
    }
  }
  metrics { event empty }
}
