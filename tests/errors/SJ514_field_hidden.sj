sj 1
game streets {
  episode 20
  kind grass "." { field seed : { none, some } = none }
  kind road "r" {
    field way : { north, south } = north  field toll : { free, paid } = free  field repaired : { no_, yes_ } = no_
    glyph "s" with way = south
    blocks agents when road.way is not agent.heading
  }
  map { "..r."
        "..s." }
  agents 2 { acts turn_left, turn_right, forward, stay, dig  moves relative  field goal : cell of road }
  phase start { each agent { send agent to grass }  each road { set road.repaired = yes_ } }
  schedule walk -> rule
  phase walk { move each agent }
  phase rule {
    each agent on road where road.toll is free { set road.toll = paid  set agent.goal = road }
    each agent on grass where agent chose dig and grass.seed is none { set grass.seed = some }
  }
  observe {
    show road as { goal where agent.goal is road, road }
    show grass as { road }
    hide road.toll
  }
}
