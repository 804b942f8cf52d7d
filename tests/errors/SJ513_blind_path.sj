sj 1
game streets {
  episode 20
  kind floor "."
  kind lane "l" { field way : { north, south } = north  blocks agents when lane.way is not agent.heading }
  kind hall "h" { field team : { red, blue } = red  blocks agents when hall.team is not agent.team }
  kind gate "g" { field team : { red, blue } = red  blocks agents when gate.team is not agent.team }
  kind door "D" { field state : { shut, open } = shut  blocks agents when door.state is shut }
  kind goal "o"
  map { "..ol"
        "Dhg." }
  agents 2 { acts turn_left, turn_right, forward, stay, knock  moves relative  field team : { red, blue } = blue }
  phase start { each agent { send agent to floor } }
  schedule walk -> knock
  phase walk { move each agent }
  phase knock {
    each agent where agent chose knock { each door { set door.state = open }  each gate in diamond(1) of agent { set gate.team = red } }
  }
  policy walker { seek goal }
  policy careful { seek goal avoiding hall where hall.team is not agent.team  aim line(1) at hall avoiding lane choose knock }
}
