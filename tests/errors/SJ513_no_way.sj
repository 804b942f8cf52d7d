sj 1
game ward {
  episode 20
  kind floor "."
  kind patient "p" { field state : { ill, well } = ill  blocks agents }
  kind door "D" { field state : { shut, open } = shut  blocks agents when door.state is shut }
  map { "..p."
        "D..." }
  agents 2 { acts turn_left, turn_right, forward, stay, tend  moves relative }
  phase start { each agent { send agent to floor } }
  schedule walk -> tend
  phase walk { move each agent }
  phase tend {
    each agent where agent chose tend { each door in diamond(1) of agent { set door.state = open } }
    each agent as a where a chose tend { each patient in diamond(1) of a where patient.state is ill { set patient.state = well } }
  }
  policy nurse { seek patient where patient.state is ill  aim diamond(1) at patient choose tend }
  policy porter { seek door as d where d.state is shut  seek door where door.state is open  seek door }
  policy follower { seek agent as other  seek agent as other where other is not agent }
  checks { expect count(patient) == 1 with seek patient, seek floor over 1 episodes }
}
