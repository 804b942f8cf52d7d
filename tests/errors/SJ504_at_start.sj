sj 1
game begun "Conditions that cannot hold when an episode begins" {
  episode 9
  kind grass "." { field worms : 0 .. 9 = 0 }
  map { "..." }
  agents 2 { acts stay, forward  moves relative  field bag : 0 .. 9 = 0 }
  phase start { each agent { send agent to grass } }
  phase claim at start {
    each agent on grass where agent.bag > 20 { set grass.worms = 3 }
    when step > 2 { each agent { set agent.bag = 4 } }
    when step == 0 { each agent on grass { set agent.bag = grass.worms } }
  }
  schedule walk
  phase walk { move each agent }
}
