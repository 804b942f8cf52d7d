sj 1
game sight "What is seen depends on who looks, and from where" {
  size far : cells = 2
  field weather : { sun, rain } = sun
  field king    : agent
  episode 20
  kind grass "."
  kind bush  "b"
  kind plot  "p" { field owner : agent  field crop : { bare, ripe } = bare  glyph "P" with crop = ripe }
  kind yard  "y" { field owner : agent }
  kind pile  "s" { field worth : 0 .. 3 = 2 }
  kind crate "c" { field store : agent }
  group land = plot, yard
  map { ".bpy."
        "cP.sb"
        "....." }
  agents 3 {
    acts turn_left, turn_right, forward, stay, claim, rest
    moves relative
    field role   : { scout, farmer } = farmer
    field bag    : 0 .. 5 capped = 0
    field helper : agent
  }
  phase start {
    each agent { send agent to grass  when agent.index == 0 { set agent.role = scout } }
  }
  schedule walk -> take -> tick
  phase walk { move each agent }
  phase take {
    each agent as a on land as cell where a chose claim { set cell.owner = a  add 1 to a.bag }
    each agent as a on crate as cell where a chose claim { set cell.store = a }
    each agent as a where a chose claim { mark line(2) of a }
    each agent as a where a chose rest and a.bag > 1 { send a to grass after 3 otherwise stay }
    each agent as a where a chose rest { first agent as b in line(2) of a { set a.helper = b } }
    when step == 4 { set weather = rain }
    when king is nobody { pick 1 agent where agent.bag > 0 { set king = agent } }
  }
  observe {
    window ahead 2, behind 1, left 1, right 1
    window ahead 4, right 3 when agent.role is scout
    window ahead 1, left 0 when weather is rain and agent.row == 2
    hide content on agents
    show land.owner
    show crate.store
    show plot.crop when distance(agent, plot) <= far or plot.row == agent.row
    show pile as { rich where pile.worth > 1 and distance(pile, agent) < 3, pile_of_all where nobody on pile, pile_taken }
    show agent.row
    show agent.heading
    show agent.moved
    show agent.bag when weather is sun
    show agent.helper
    show other.index when not (other on bush and distance(agent, other) > 1)
    show other.role when distance(agent, other) < 3
    show everyone.away
    show everyone.col
    show everyone.bag as { gone where everyone.away, near where distance(agent, everyone) < 3, far_off }
    show weather when agent.bag > 0
    show king
  }
}
