sj 1
game adding "Reals that decide are added to: everybody's, a row's, an entry's, somebody else's" {
  param rate : number = 0.1 in 0 .. 1
  param pay by { red, blue } : reward = { red: 0.3, blue: 0.7 }
  episode 30
  field pot  : reward
  field box  by { red, blue } : reward
  field most : { red, blue } = red
  kind land "." { field heat : reward }
  kind sand ":" { field heat : reward }
  group ground = land, sand
  map { "..::.."
        ".::..." }
  agents 3 {
    acts turn_left, turn_right, forward, stay
    moves relative
    field owed  : reward
    field trust by agent : reward
    field purse by { red, blue } : reward
    field friend : agent  field hits by { red, blue } : 1 .. 9 capped = 1
    field likes : { red, blue } = red
    field rich  : 0 .. 9 capped = 0
  }
  phase start { each agent { send agent to ground } }
  phase meet {
    each agent as a { pick 1 agent as b where b is not a { set a.friend = b } }
    each agent where agent.moved { set agent.likes = blue }
    each agent where not agent.moved { set agent.likes = red }
  }
  phase add_up {
    add rate to pot
    each agent as a {
      add 0.1 to pot
      add a.owed * rate to pot
      add rate to a.owed
      each agent as b { add 0.1 to a.trust[b]  add a.owed * 0.3 to b.trust[a] }
      each agent as b where b.moved { add b.owed * rate - 0.01 to a.owed }
      each agent as b in a.friend { add 0.7 to b.owed  add a.owed * rate to b.purse[a.likes]  add 0.2 to b.trust[a] }
      add pay[a.likes] * rate to a.purse[a.likes]
      add 0.3 to a.purse[red]
      add 0.1 to box[a.likes]
      add a.owed * 0.1 to box[blue]
    }
    each agent on ground as cell { add 0.1 to cell.heat  add agent.owed * rate to cell.heat }
    each ground { add 0.01 to ground.heat }
  }
  phase decide {
    when box[red] * rate + pot > box[blue] { set most = blue } otherwise { set most = red }
    each agent as a where a.owed - a.purse[red] * rate > a.purse[blue] { add 1 to a.rich }
    each agent as a where sum(a.purse) * rate > a.owed { add 1 to a.rich }
    each agent as a where pay[mix(a.hits)] * rate > 0.05 { add 1 to a.hits[a.likes] }
    each agent as a { each agent as b where a.trust[b] > b.trust[a] { add 1 to a.rich } }
    when sum(ground.heat * rate over ground) > pot { end }
    each agent where agent.owed > 50 { set agent.owed = agent.owed * 0.01 }
  }
  phase walk { move each agent }
  phase waver {
    each agent where agent.owed > 1 {
      chance rate * 0.3 { set agent.likes = red }
      otherwise chance max(0.125 over land otherwise 0.125) { set agent.likes = blue }
      otherwise chance rate * 0.7 + 0.1 { set agent.friend = nobody }
    }
  }
  schedule walk -> meet -> waver -> add_up -> decide
  observe { window ahead 1, behind 1, left 1, right 1  show agent.rich }
}
