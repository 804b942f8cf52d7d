sj 1
game looking "What is shown, renamed and hidden" {
  field weather : { sun, rain } = sun
  episode 10
  kind grass "."
  kind chest "c" {
    field state : { full, empty } = full
    field owner : { red, blue } = red  glyph "C" with owner = blue
  }
  map { ".cC." }
  agents 2 {
    acts stay, open
    field team : { red, blue } = red
    field bag  : 0 .. 5 capped = 0
  }
  phase start { each agent { send agent to grass  when agent.index == 1 { set agent.team = blue } } }
  schedule take
  phase take {
    each agent as a where a chose open {
      first chest in line(1) of a where chest.state is full { set chest.state = empty }
      add 1 to a.bag
    }
    when step == 5 { set weather = rain }
  }
  observe {
    window ahead 2, behind 1, left 1, right 1
    show chest.owner as { mine where chest.owner is agent.team, theirs }
    hide chest.state when weather is rain
    show agent.bag
    show other.team
    show weather
  }
}
