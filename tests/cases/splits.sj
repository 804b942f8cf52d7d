sj 1
game splits "Tasks to learn from, and tasks held out" {
  param reward : reward = 1
  episode 2 trials of 3
  task rules {
    field feeding : { red, green, blue }
    field pay by { red, green, blue } : different 0 .. 4
    field order by { red, green, blue } : { red, green, blue }
    field delay : -1 .. 1
  }
  train on 8 of rules seed 3
  hold out rich of rules where pay[red] > 2 and order[blue] is not green
  hold out late of rules where delay == 1 and pay[blue] + pay[red] < 3
  kind tree  "T" { field hue : { red, green, blue } = red  field fruit : { none, ripe } = ripe }
  kind grass "."
  map { "T.T."  ".T.T" }
  agents 2 { acts turn_left, forward, stay  moves relative }
  phase start {
    each agent { send agent to grass }
    each tree { draw hue from { red, green, blue }  set tree.hue = order[hue] }
  }
  schedule walk -> eat
  phase walk { move each agent }
  phase eat {
    each agent on tree where tree.fruit is ripe and delay < 1 {
      set tree.fruit = none
      when tree.hue is feeding { give pay[tree.hue] * reward to agent }
    }
  }
  observe { window ahead 1, behind 1, left 1, right 1 }
  metrics { final paid = pay[red] }
}
