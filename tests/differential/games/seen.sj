sj 1
game seen "Who sees what, under every odd condition" {
  field night : { light, dark } = light
  episode 40
  kind grass "."
  kind wall  "#" { blocks agents }
  kind bush  "b" { field fruit : { none, ripe } = ripe }
  kind den   "d" { field fruit : { none, ripe } = none  field owner : agent }
  group green = bush, den
  map { ".b.d"
        "#..b"
        "d..." }
  agents 4 {
    acts stay, turn_left, turn_right, forward, grab, sleep
    moves relative
    field sharp  : { yes_, no_ } = no_
    field friend : agent
    field bag    : 0 .. 3 capped = 0
    timer tired
  }
  phase start { each agent { send agent to grass  when agent.index < 2 { set agent.sharp = yes_ } } }
  schedule walk -> act -> tick
  phase walk { move each agent }
  phase act {
    each agent as a on green as cell where a chose grab and cell.fruit is ripe { set cell.fruit = none  add 1 to a.bag }
    each agent as a on den as cell where a chose grab { set cell.owner = a }
    each agent as a where a chose grab { mark square(1) of a }
    each agent as a where a chose grab { pick 1 agent as b in square(2) of a { set a.friend = b } }
    each agent as a where a chose sleep { set a.tired = 3  chance 0.3 { send a to grass after 2 otherwise stay } }
    chance 0.1 { set night = dark } otherwise chance 0.1 { set night = light }
  }
  observe {
    window ahead 0, behind 3 when night is dark and agent.sharp is no_
    window ahead 3, right 2 when agent.row < 1 or agent.friend is not nobody
    hide marks on agents
    show green.fruit as { mine where nobody on green and green.col == agent.col, here where distance(green, agent) == 0, other_fruit }
    hide den.fruit when count(agent as x in disc(1) of den) > 1
    show den.owner when agent.bag > 0
    hide marks on green when distance(agent, green) > 1
    show other.friend when not (other.tired > 0 and not (other is agent.friend) or night is dark and agent.heading is not other.heading)
    show other.row when other.heading is north
    show other.moved when agent.bag < 2
    show everyone.friend when everyone is agent or everyone.tired == 0
    show everyone.row
    show everyone.heading as { gone where everyone.away, near where distance(everyone, agent) < 2, far_off }
    show agent.index
    show agent.friend
    show agent.tired when night is light
    show night when agent.sharp is yes_
  }
}
