sj 1
game turning "Turning and stepping forward only, in a maze with doors" {
  size reach : cells = 3
  episode 40
  kind floor "." { field fruit : { none, ripe, bad } = none }
  kind wall  "#" { blocks agents, ray }
  kind gate  "P"
  map { "P...#...P"
        ".#.#.#.#."
        "..P...P.."
        ".#.#####."
        "P...#...P" }
  agents 5 {
    acts turn_right, stay, forward, turn_left, hit
    moves relative
    field bag : 0 .. 3 capped = 0
  }
  shape ray = line(reach)
  phase start { each agent { send agent to gate } }
  schedule grow -> tick -> walk -> eat -> shoot
  phase grow {
    each floor where floor.fruit is none and nobody on floor { chance 0.2 { draw what from { ripe, bad }  set floor.fruit = what } }
  }
  phase walk { move each agent }
  phase eat { each agent on floor where floor.fruit is not none { set floor.fruit = none  add 1 to agent.bag } }
  phase shoot { each agent as one where one chose hit { each agent as other in ray of one { send other to gate after 2 } } }
  observe { window ahead 2, behind 2, left 2, right 2  show agent.bag }
  policy picky { seek floor where floor.fruit is ripe avoiding floor where floor.fruit is bad }
  policy careless { seek floor where floor.fruit is not none avoiding floor where floor.fruit is ripe }
  policy archer {
    when agent.bag == 3 choose turn_left
    aim ray at agent as other where other.bag > agent.bag avoiding floor where floor.fruit is bad choose hit
    seek floor in disc(5) of agent where floor.fruit is ripe
    when count(agent as other) < 5 choose turn_right
  }
  policy near_wall { aim square(1) at wall choose hit }
  policy loner { seek gate avoiding floor in disc(2) of agent where floor.row == agent.row  when step > 2 choose hit }
  policy follower { seek agent as other where other.index == 0 and agent.index != 0  seek gate }
}
