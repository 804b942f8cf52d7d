sj 1
game headings "Headings that are none" {
  episode 3
  kind road "." { field way : { north, east, up } = east  field toll : 0 .. 3 = 0 }
  map { "..." }
  agents 2 { acts stay, forward  moves relative }
  phase start { each agent { send agent to road facing north } }
  schedule turn -> lot -> back -> more
  phase turn { each agent on road { set agent.heading = road.way } }
  phase lot { each agent as a { each agent as b in line(1) of a { set b.heading = a.heading by lot } } }
  phase back { each agent on road { send agent by 1 ahead facing road.toll otherwise stay } }
  phase more { each agent on road { add 1 to agent.heading } }
}
