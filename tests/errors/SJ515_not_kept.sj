sj 1
game kept "What cannot be kept from trial to trial" {
  episode 3 trials of 10 { keep agent.heading, grass.row, deer.heading, step, trial }
  kind grass "." { field height : 0 .. 3 = 0 }
  map { "..." }
  field mood : 0 .. 9 = 0
  agents 1 { acts stay, forward  moves relative }
  movers deer 1 "d"
  phase start { each agent { send agent to grass }  each deer { send deer to grass } }
  schedule grow
  phase grow { each grass { set grass.height = 3 }  set mood = 1 }
}
