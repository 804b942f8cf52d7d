sj 1
game guarding "Guarded rules, the cell underfoot, and doors that open for some agents" {
  episode 40
  kind grass "."
  kind road  "r" { field way : { north, east, south, west } = east  field toll : 0 .. 3 capped = 0  glyph "l" with way = south }
  kind door  "D" { field team : { red, blue } = red  blocks agents when door.team is not agent.team  glyph "B" with team = blue }
  kind camp  "c" { blocks agents when agent.index == 0 }
  kind shed  "#" { blocks agents }
  kind lodge "L" { field floor : 0 .. 2 = 1 }
  map { "..rrrl.D.."
        "....c.#B.c"
        "rr.D..#..l" }
  agents 4 {
    acts turn_left, turn_right, forward, stay, pay(0 .. 3), swap
    moves relative
    field team  : { red, blue } = red
    field purse : 0 .. 9 capped = 2
  }
  phase start {
    each agent { send agent to grass facing same  when agent.index % 2 == 1 { set agent.team = blue } }
  }
  phase settle at start { each agent { set agent.heading = case agent.team { red: east, blue: south } } }
  schedule walk -> work
  phase walk { move each agent }
  phase work {
    each agent on road where agent chose pay(2) { add 1 to road.toll  add 1 to agent.purse }
    each agent where agent chose swap { when agent.team is red { set agent.team = blue } otherwise { set agent.team = red } }
  }
  observe { window ahead 2, behind 2, left 2, right 2 }
  policy payer {
    when on road where road.toll < 2 choose pay(road.toll)
    when on road as here where here.way is not agent.heading choose turn_left
    when agent.purse < 4 seek road where road.toll == 0
    when on grass aim line(2) at door as other where other.team is not agent.team choose swap
    seek door
  }
  policy walker {
    when on lodge choose swap
    when on road as here seek road as other where other.way is not here.way avoiding road as third where third.row == here.row
    when agent.index > 1 and step % 3 == 0 aim line(2) at agent as other where other.team is not agent.team choose swap
    when on camp choose swap
    seek camp
  }
}
