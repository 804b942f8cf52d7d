sj 1
game one_door "Four doors, of which one is open to an agent at each step, and nobody sees which" {
  episode 8

  kind floor "."
  map { ".." }

  agents 2 {
    acts stay, north, east, south, west
    field open : { north, east, south, west } = north
    forbid north when agent.open is not north
    forbid east  when agent.open is not east
    forbid south when agent.open is not south
    forbid west  when agent.open is not west
  }

  phase start { each agent { send agent to floor  chance 0.5 { set agent.open = south } } }
  schedule go -> turn
  phase go {
    each agent where agent chose north or agent chose east or agent chose south or agent chose west { give 1 to agent  tally went for agent }
  }
  phase turn {
    each agent {
      when agent.open is north { set agent.open = east } otherwise when agent.open is east { set agent.open = south }
      otherwise when agent.open is south { set agent.open = west } otherwise { set agent.open = north }
    }
  }

  metrics { event went }
  observe { window ahead 0, behind 0, left 0, right 0 }
}
