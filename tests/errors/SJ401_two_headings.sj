sj 1
game headings "Headings that two statements set" {
  episode 3
  kind road "." { field way : { north, east } = east }
  map { "..." }
  agents 2 { acts stay, forward  moves relative }
  phase start { each agent { send agent to road } }
  schedule turn -> leave
  phase turn { each agent as a { each road { set a.heading = road.way } } }
  phase leave {
    each agent on road {
      set agent.heading = road.way
      when agent.index == 0 { send agent by 1 ahead facing south otherwise stay }
    }
  }
}
