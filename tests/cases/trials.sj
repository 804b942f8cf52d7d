sj 1
game trials "Trials" {
  size  trials : count = 3
  param length : steps = 7 in 3 .. 9
  episode trials trials of length { keep grove.hue, agent.best, deer.tame, hunger, luck }
  kind tree "T" { field hue : { red, green } = red  field fruit : { none, ripe } = ripe  timer bare }
  kind bush "b" { field hue : { red, green } = green }
  kind soil "."
  group grove = tree, bush
  map { "T.b.."  "..T.."  ".b..T" }
  field luck : 0 .. 9 = 0
  field mood : 0 .. 9 = 0
  timer hunger
  agents 2 {
    acts turn_left, turn_right, forward, stay
    moves relative
    field best  : 0 .. 9 = 0
    field eaten : 0 .. 9 capped = 0
  }
  movers deer 1 "d" { field tame : 0 .. 9 capped = 0 }
  schedule tick -> walk -> tame -> eat -> end_early
  phase start {
    each agent { send agent to soil }
    each deer { send deer to soil }
    each grove { chance 0.5 { set grove.hue = green } otherwise { set grove.hue = red } }
    draw luck_now from 1 .. 9
    set luck = luck_now
    set mood = luck_now
    each agent where trial > 0 { set agent.eaten = min(9, agent.best + luck) }
  }
  phase walk { move each agent }
  phase tame { each agent as a { each deer where distance(a, deer) == 1 { add 1 to deer.tame } } }
  phase eat {
    each agent on tree where tree.fruit is ripe {
      set tree.fruit = none
      set tree.bare = 2
      add 1 to agent.eaten
      tally ate for agent
      when tree.hue is green { give 1 to agent  when trial > 0 { give 2 to agent } }
      set agent.best = max(agent.best, agent.eaten)
    }
    when hunger == 0 { set hunger = 5 }
  }
  phase end_early { when any (agent where agent.eaten == 2) and step > 2 { end } }
  observe { window ahead 2, behind 2, left 2, right 2  show tree.fruit  show trial  show step }
  metrics { event ate  mean ripe_left = count(tree where tree.fruit is ripe)  final tameness = sum(deer.tame over deer) }
  checks {
    always trial < trials
    always step <= 9
    once luck > 0 always luck > 0
    conserved count(grove where grove.hue is red) + count(grove where grove.hue is green)
    expect trial == trials - 1 with random, seek tree where tree.fruit is ripe over 3 episodes
  }
}
