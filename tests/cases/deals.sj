sj 1
game deals "Rows that are drawn" {
  episode 9
  kind tree  "T" { field hue : { red, green, blue } = red  field worth by { red, green, blue } : 0 .. 9 = 0 }
  kind grass "."
  map { "T.T."  ".T.." }
  field pay    by { red, green, blue } : 0 .. 9 = 0
  field rank   by 1 .. 4 : { red, green, blue } = red
  field recipe by { red, green, blue } : -3 .. 3 = 0
  field share  by { red, green, blue } : reward = 0
  agents 2 {
    acts turn_left, forward, stay  moves relative  field luck by { red, green, blue } : 0 .. 9 = 0  field code by agent : 0 .. 9 = 0
  }
  phase start { each agent { send agent to grass } }
  schedule deal -> walk -> pay_out
  phase deal {
    draw price by { red, green, blue } from 2 .. 9
    set pay = price
    draw order by 1 .. 4 from { red, green, blue }
    set rank = order
    draw dealt by { red, green, blue } from different -3 .. 3
    set recipe = dealt
    draw part by { red, green, blue } from 0.5 .. 1.5
    set share = part
    each agent {
      draw fortune by { red, green, blue } from different 0 .. 2
      set agent.luck = fortune
      draw number by agent from 0 .. 9
      set agent.code = number
    }
    each tree {
      draw worth by { red, green, blue } from { 1: 0.25, 4: 0.25, 9: 0.5 }
      set tree.worth = worth
      draw hues by { red, green, blue } from different { red, green, blue }
      set tree.hue = hues[green]
    }
  }
  phase walk { move each agent }
  phase pay_out { each agent on tree { give share[tree.hue] to agent  when tree.worth[tree.hue] > pay[red] { tally lucky } } }
  observe { window ahead 1, behind 1, left 1, right 1 }
  metrics { event lucky  mean paid = sum(share) }
}
