# An agent was added to every entry of a row of sets, though one entry was named.
sj 1
game found {
  episode 20
  kind grass "." { field seen by { low, red, glad } : set of agent }
  map { "...."  "...." }
  agents 3 {
    acts forward, stay
    field met by { low, red, glad } : set of agent
  }
  phase start { each agent { send agent to grass } }
  schedule meet
  phase meet {
    each agent on grass { add agent to grass.seen[case agent chose stay { yes: red, no: low }] }
    match agent as a with agent as b { add a to b.met[glad] }
    each grass where nobody on grass { each agent in grass.seen[red] { add agent to agent.met[low] } }
  }
}
