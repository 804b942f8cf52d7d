sj 1
game streets {
  episode 20
  kind grass "."
  kind road ">" { field way : { east, south } = east  glyph "v" with way = south }
  map { "..>."
        "..v." }
  agents 2 { acts forward, stay  moves relative }
  phase start { each agent { send agent to grass } }
  schedule walk -> rule
  phase walk { move each agent }
  phase rule { each agent on road where road.way is east { give 1 to agent } }
}
