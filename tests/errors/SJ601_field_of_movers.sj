sj 1
game g { episode 3 
  kind grass "."
  map { "...." }
  agents 1 { acts stay  field prey : deer }
  movers deer 1 "d"
  phase start { each agent { send agent to grass } each deer { send deer to grass } }
  schedule r  phase r { each agent as a { set a.prey = nobody } } }
