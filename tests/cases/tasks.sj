sj 1
game tasks "Rules drawn for each episode" {
  episode 2 trials of 5
  task rules {
    field feeding : { red, green, blue }
    field pay by { red, green, blue } : different 0 .. 9
    field order by { red, green, blue } : { red, green, blue }
    field delay : -1 .. 2
  }
  kind tree  "T" { field hue : { red, green, blue } = red  field fruit : { none, ripe } = ripe }
  kind grass "."
  map { "T.T."  ".T.T" }
  agents 2 { acts turn_left, forward, stay  moves relative  forbid turn_left when feeding is red }
  phase start {
    each agent { send agent to grass }
    each tree { draw hue from { red, green, blue }  set tree.hue = order[hue] }
  }
  schedule walk -> eat
  phase walk { move each agent }
  phase eat {
    each agent on tree where tree.fruit is ripe and delay < 2 {
      set tree.fruit = none
      when tree.hue is feeding { give 1 to agent  tally fed by pay[tree.hue] }
    }
  }
  observe { window ahead 1, behind 1, left 1, right 1  show feeding }
  metrics { event fed  final paid = pay[red] }
  checks {
    always pay[red] != pay[green] and delay >= -1
    conserved delay + pay[blue]
    expect step == 5 with random over 3 episodes
  }
}
