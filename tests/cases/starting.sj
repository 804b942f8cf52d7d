sj 1
game starting "Phases with which an episode begins" {
  size trials : count = 3
  episode trials trials of 4 { keep begun, soil.taken }
  kind house "H"
  kind soil  "." { field owner : agent  field near : { no, yes } = no  field taken : 0 .. 9 capped = 0 }
  kind camp  "c"
  map { "H...c"  "....H"  "..c.c" }
  field begun : 0 .. 9 = 0
  field owned : 0 .. 99 = 0
  agents 2 {
    acts turn_left, turn_right, forward, stay
    moves relative
    field home : cell of house
  }
  movers deer 2 "d"
  movers kite 1 "k"
  phase start {
    each agent { send agent to camp facing east }
    each deer { send deer to soil }
    each kite { send kite to camp }
  }
  phase settle at start { each agent as a { each house where distance(a, house) < 4 { set a.home = house by lot } } }
  phase claim at start {
    each soil {
      each agent as a {
        each agent as b where a.index != b.index and distance(a, soil) < distance(b, soil) {
          set soil.owner = a by lot
          add 1 to soil.taken
        }
      }
      each agent where agent.home is not nowhere and distance(agent.home, soil) == 1 { set soil.near = yes }
    }
    set begun = min(9, begun + 1)
  }
  phase scatter at start {
    each deer { send deer by 2 south otherwise stay }
    each kite { send kite to soil where soil.near is yes after 2 facing south otherwise stay }
  }
  phase stroll at start { move each deer at random avoiding house }
  phase sum_up at start { set owned = min(99, count(soil where soil.owner is not nobody) + 10 * begun) }
  schedule tick -> walk -> fly
  phase walk { move each agent }
  phase fly { move each kite ahead }
  observe {
    window ahead 2, left 1, right 1
    hide other.heading
    show soil.owner as { mine where soil.owner is agent, others where soil.owner is not nobody, free }
  }
  metrics { mean most_owned = owned  final taken_by_now = sum(soil.taken over soil) }
  checks {
    always begun == 1
    conserved owned + begun
    symmetric agents
    expect trial == trials - 1 with random over 3 episodes
  }
}
