sj 1
game yard "Three agents pick apples in a yard: a little of everything an environment reports" {
  param length : steps       = 6
  param apple  : reward      = 1
  param regrow : probability = 0.3
  episode length

  kind grass "."
  kind tree  "T" { field fruit : { none, ripe } = ripe }
  kind wall  "#" { blocks agents }
  map {
    "T..T"
    "TT#."
    ".T.."
  }

  agents 3 {
    acts turn_left, turn_right, forward, stay, rest
    moves relative
    field bag : 0 .. 9 capped = 0
    timer tired
    forbid forward, rest when agent.tired > 0
  }

  phase start { each agent { send agent to grass } }
  schedule tick -> grow -> walk -> eat -> close

  phase grow { each tree where tree.fruit is none and nobody on tree { chance regrow { set tree.fruit = ripe } } }
  phase walk { move each agent }
  phase eat {
    each agent on tree {
      when tree.fruit is ripe { give apple to agent  add 1 to agent.bag }
      set tree.fruit = none
      tally visits[tree.fruit] for agent
    }
    each agent where agent chose rest { set agent.tired = 2  tally rests }
  }
  phase close { when count(tree where tree.fruit is ripe) == 0 { end } }

  observe { window ahead 2, behind 1, left 1, right 2  show agent.bag }
  metrics { event visits by { none, ripe }  event rests  mean ripe = count(tree where tree.fruit is ripe) }
}
