sj 1
game looks "Cells that look like others, and what is hidden" {
  episode 10
  kind gate  "P"
  kind floor "."
  kind soil  "a" { field fruit : { none, ripe } = none  glyph "A" with fruit = ripe  field owner : agent }
  kind water "w" { field state : { clean, dirty } = clean }
  kind wall  "#" { blocks agents }
  group wet = water, soil
  map { "P.aA#"  "PPwwP" }
  agents 2 { acts stay, forward, turn_left, zap }
  shape beam = line(3)
  phase start { each agent { send agent to gate } }
  schedule walk -> own -> fire
  phase walk { move each agent }
  phase own { each agent on soil { set soil.owner = agent } }
  phase fire { each agent as a where a chose zap { mark beam of a } }
  observe {
    window ahead 2, behind 1, left 1, right 1
    show gate as { floor }
    show wall as { outside }
    show soil as { apple where soil.fruit is ripe, mine where soil.owner is agent, floor }
    hide marks on water when water.state is dirty
    hide marks on gate
    hide marks on agents
    hide content on agents
  }
}
