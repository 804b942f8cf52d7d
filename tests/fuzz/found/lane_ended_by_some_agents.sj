# A condition on the agents that end a lane was not spread over the cells of the lane: strict JAX refused the phase.
sj 1
game goals {
  episode 20
  kind rock "."
  kind tree "t" { field age : { ripe, low } = low }
  map { "..tt...."  "....t..."  "..t....t"  "......t." }
  agents 2 { acts stay, forward, turn_left  moves relative  blocks beam when agent.moved }
  movers ball 2 "d" { }
  shape beam = line(2)
  phase start { each agent { send agent to rock }  each ball { send ball to rock } }
  schedule walk -> roll -> look_round
  phase walk { move each agent }
  phase roll { move each ball toward tree in beam of ball }
  phase look_round { each agent { when count(tree in beam of agent) > 0 { give 1 to agent } } }
}
