sj 1
game orchard "A Small Orchard" {
  size  players : count       = 2 in 1 .. 3
  param growth  : probability = 0.3
  episode 12

  kind floor "."
  kind wall  "#" { blocks agents }
  kind soil  "A" { field fruit : { none, ripe } = ripe  field owner : agent  field eaten : 0 .. 99 = 0 }
  map { "########"
        "#..AA..#"
        "#.AAAA.#"
        "########" }

  agents players {
    acts turn_left, turn_right, forward, stay, sing
    moves relative
    timer tired
    forbid all when agent.tired > 0
  }
  shape voice { "xxx"
                ".^." }
  phase start { each agent { send agent to floor } }
  schedule tick -> walk -> eat -> grow -> sing
  phase walk { move each agent }
  phase eat {
    each agent on soil where soil.fruit is ripe {
      set soil.fruit = none
      set soil.owner = agent
      when soil.eaten < 99 { add 1 to soil.eaten }
      give 1 to agent
      tally eaten for agent
    }
  }
  phase grow { each soil where soil.fruit is none { chance growth { set soil.fruit = ripe } } }
  phase sing { each agent where agent chose sing { mark voice of agent  set agent.tired = 2 } }
  observe { window ahead 2, behind 1, left 1, right 1 }
  metrics { event eaten }
  policy eater { seek soil where soil.fruit is ripe avoiding soil where soil.eaten > 2  when step > 8 choose sing }
}
