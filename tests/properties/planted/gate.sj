sj 1
game gate "A door stands open while somebody is on its plate" {
  episode 200
  kind hall  "."
  kind wall  "#" { blocks agents }
  kind plate "p"
  kind door  "D" { field open : { no, yes } = no  blocks agents when door.open is no }
  kind vault "v" { field gold : { no, yes } = yes }
  map { "...#vv"
        "p..Dvv"
        "...#vv" }
  agents 3 { acts turn_left, turn_right, step_left, step_right, forward, backward, stay  moves relative }
  phase start { each agent { send agent to hall } }
  schedule walk -> swing -> loot
  phase walk { move each agent }
  phase swing {
    each door {
      when count(agent on plate) > 0 { set door.open = yes } otherwise when nobody on door { set door.open = no }
    }
  }
  phase loot { each agent on vault where vault.gold is yes { set vault.gold = no  give 10 to agent  tally looted for agent } }
  metrics { event looted }
  checks { always count(agent on door where door.open is no) == 0 }
  variant fault "the door falls shut on whoever stands in it" {
    phase swing {
      each door { when count(agent on plate) > 0 { set door.open = yes } otherwise { set door.open = no } }
    }
  }
}
