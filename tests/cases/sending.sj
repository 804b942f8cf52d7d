sj 1
game sending "Agents sent home for a while, others removed" {
  size delay : steps = 2 in 0 .. 9
  episode 10
  kind grass "."
  kind home  "h" { field state : { free, shut } = free  glyph "H" with state = shut }
  map { "..hhH" }
  agents 2 { acts stay, leave, vanish }
  phase start { each agent { send agent to grass } }
  schedule tick -> go
  phase go {
    each agent where agent chose leave { send agent to home where home.state is free after delay facing same otherwise stay }
    each agent where agent chose vanish { remove agent }
  }
}
