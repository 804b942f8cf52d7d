sj 1
game chosen "A condition that reads all of a long row" {
  episode 5
  task rules { field price by 0 .. 7 : 0 .. 9 }
  hold out dear of rules where sum(price) > 40
  kind grass "."
  map { "..." }
  agents 2 { acts stay, forward  moves relative }
  phase start { each agent { send agent to grass } }
  schedule pay -> walk
  phase pay { when price[0] > 4 { give 1 to all } }
  phase walk { move each agent }
}
