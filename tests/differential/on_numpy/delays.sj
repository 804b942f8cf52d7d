sj 1
game delays "How long each of a pair is away, as one of the two says" {
  size longest : steps = 4
  episode 40
  kind road "."
  kind gate "g"
  map { "..g..g."
        "......."
        ".g...g." }
  agents 5 {
    acts forward, turn_left, turn_right, stay, zap
    moves relative
    field wait : 0 .. longest = 0
  }
  phase start { each agent { send agent to road } }
  schedule walk -> meet -> tick -> draw_waits
  phase walk { move each agent }
  phase meet {
    match agent as a with first agent as b in line(3) of a where a chose zap {
      each agent as one in { a, b } { send one to gate after a.wait otherwise stay }
    }
  }
  phase draw_waits { each agent { draw next from 0 .. 3  set agent.wait = next } }
}
