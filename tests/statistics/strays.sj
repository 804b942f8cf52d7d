sj 1
game strays "What movers draw: where they stray, and who of two comes to one cell" {
  episode 10
  kind gap "."
  map { "..........."  "..........."  "..........."  "..........." }
  movers hen 3 "n"
  movers pawn 2 "p"
  agents 1 { acts stay }
  phase start { each agent { send agent to gap }  each hen { send hen to gap }  each pawn { send pawn to gap } }
  schedule stray -> push
  phase stray { move each hen at random }
  phase push { each pawn { send pawn by 1 ahead otherwise stay } }
}
