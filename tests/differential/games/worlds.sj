sj 1
game worlds "World fields, world draws, nesting" {
  size  players : count       = 3 in 1 .. 5
  param grow    : probability = 0.4
  param split   : probability = 0.5
  episode 30
  field season : { wet, dry } = wet
  field left   : 0 .. 100 = 10
  timer storm
  kind land "." { field life : { bare, grass, tree } = bare  field age : 0 .. 3 = 0  timer burn }
  kind spot "S"
  map { "S...S"
        "....."
        "S...." }
  agents players {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, burn, plant  moves relative  field seeds : 0 .. 9 capped = 3
  }
  phase start { each agent { send agent to spot }  each land { chance split { set land.life = grass } } }
  schedule weather -> walk -> tick -> act -> grow -> spread -> reward(wet) -> reward(dry)
  phase weather {
    chance 0.25 { set season = case season { wet: dry, dry: wet }  set storm = 2 }
    otherwise { when storm == 0 { set left = max(0, left - 1) } }
  }
  phase walk { move each agent }
  phase act {
    each agent on land {
      when agent chose plant and agent.seeds > 0 and land.life is bare { set land.life = tree  add -1 to agent.seeds }
      otherwise when agent chose burn { set land.burn = 3 }
      otherwise { chance grow { add 1 to agent.seeds } otherwise chance split { add 2 to agent.seeds } otherwise { give 0.5 to agent } }
    }
  }
  phase grow {
    each land where land.life is not tree {
      let trees = count(land as other in square(1) of land where other.life is tree and other.age >= land.age)
      let total = sum(other.age over land as other in diamond(1) of land)
      when trees > 0 and total < 5 { chance min(1, grow * 0.5) { set land.life = case land.life { bare: grass, otherwise: tree } } }
      set land.age = total % 4
    }
    when season is dry { pick 2 land where land.life is tree { set land.life = bare } otherwise { add 1 to left_count } }
  }
  field left_count : 0 .. 50 capped = 0
  phase spread {
    pick 1 land where land.burn > 0 {
      each land as other in disc(1) of land where other.life is not bare { set other.life = bare }
      pick 1 agent as hero { give 1 to hero  tally hero for hero }
      draw how from 0 .. 2
      when how == 1 { give 0.25 to all }
    }
    each agent {
      each agent as other where other.index > agent.index and other.seeds == agent.seeds { give 0.1 to agent  tally same by 2 for other }
    }
  }
  phase reward(when_is) { when season is when_is { give case when_is { wet: 1, dry: -1 } to all  tally season[when_is] } }
  observe {
    window ahead 2, behind 2, left 2, right 2
    show season
    show left
    show storm
    show agent.seeds
    hide land.life when land.age > 2 and agent.seeds == 0
  }
  metrics { event hero  event same  event season by { wet, dry }  mean bare = count(land where land.life is bare) }
}
