sj 1
game own "Writes that are one instance's own" {
  episode 40
  kind grass "."
  kind tree  "T" { field fruit : { none, ripe } = ripe  field owner : agent = nobody  field age : 0 .. 9 = 0 }
  kind pond  "O" { field depth : { low, high } = low }
  map { "..T..O.."  ".T..T..."  "O...O..T"  "..TT...." }
  field chosen : agent = nobody
  field luck   : 0 .. 40 = 0
  agents 5 {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, peer
    moves relative
    field mood  : { plain, glad, sad } = plain
    field last  : agent = nobody
    field score : 0 .. 40 capped = 0
  }
  shape ray = line(4)
  phase start { each agent { send agent to grass } }
  schedule walk -> weather -> underfoot -> peer -> claim -> lottery -> share
  phase walk { move each agent }
  phase weather {
    chance 0.4 { each tree { set tree.fruit = ripe } }
    otherwise chance 0.5 { each tree where tree.row > 1 { set tree.fruit = none }  each agent { set agent.mood = plain } }
    otherwise { each agent where agent.row > 0 { set agent.mood = glad }  pick 2 tree { set tree.fruit = none } }
    when step >= 20 { each agent { set agent.score = 0 } }
    otherwise when step == 4 or step == 9 { each agent as a { each agent as b in disc(1) of a { add 1 to b.score } } }
  }
  phase underfoot {
    each agent on tree { set agent.mood = glad  set tree.age = min(agent.index + 3, 9) }
    each agent on pond { set agent.mood = sad }
    each agent where not agent on tree and not agent on pond { set agent.mood = plain }
  }
  phase peer {
    each agent as a where a chose peer {
      first agent as b in ray of a { set a.last = b  set a.score = b.index + 1 }
    }
    each agent as a where not a chose peer {
      pick 1 agent as b in disc(2) of a { set a.last = b } otherwise { set a.score = 7 }
    }
  }
  phase claim {
    each tree as t { pick 1 agent as a in disc(2) of t { set t.owner = a  set t.age = a.index } otherwise { set t.owner = nobody } }
    each agent as a { first tree in ray of a { pick 1 agent as c in disc(3) of tree { set a.last = c } } }
  }
  phase lottery {
    pick 1 tree where tree.fruit is ripe {
      set chosen = tree.owner
      pick 1 agent as a in disc(3) of tree { set a.score = 20  set luck = a.index + 10  set tree.age = a.index } otherwise { set luck = 1 }
    } otherwise { set chosen = nobody  set luck = 0 }
  }
  phase share {
    when luck > 10 { each agent { set agent.score = luck } }
    otherwise { match agent as a with agent as b in ray of a { set a.score = b.index  set b.score = a.index + 5 } }
  }
  observe { window ahead 3, behind 2, left 2, right 2  show agent.mood  show agent.score }
  metrics { mean glad = count(agent where agent.mood is glad)  final old = sum(tree.age over tree) }
}
