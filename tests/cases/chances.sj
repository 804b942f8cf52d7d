sj 1
game chances "A chain of chances with one draw; values drawn from a range, from words, from weighted words" {
  param luck : probability = 0.25 in 0 .. 0.5
  episode 10
  kind bush "b" { field berry : { none, red, blue } = none }
  map { "bbb" }
  agents 1 {
    acts stay
    field bag : 0 .. 9 = 0
  }
  phase start { each agent { send agent to bush } }
  schedule grow -> find
  phase grow {
    each bush where bush.berry is none {
      chance luck { set bush.berry = red }
      otherwise chance 2 * luck {
        draw colour from { red: luck, blue: 1 - luck }
        set bush.berry = colour
      }
    }
  }
  phase find {
    each agent {
      draw number from 3 .. 5
      draw colour from { red, blue }
      set agent.bag = number
      tally found[colour] for agent
    }
  }
  metrics { event found by { red, blue } }
}
