sj 1
# A tree bears fruit, the other one doesn't, and which is which is hidden. It stays so for the five trials of an episode:
# who tries in the first trial what to eat knows in the others.
game two_trees "Two trees" {
  about summary "Find out in the first trial which of two trees bears fruit, and return to it in the others."

  episode 5 trials of 10 { keep tree.bears }

  kind tree  "T" { field bears : { nothing, fruit } = nothing }
  kind grass "."
  map {
    "T...T"
  }

  agents 1 {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay
    moves relative
  }

  phase start {
    each agent { send agent to grass facing north }
    pick 1 tree { set tree.bears = fruit }
  }
  schedule walk -> eat
  phase walk { move each agent }
  phase eat {
    each agent on tree {
      when tree.bears is fruit { give 1 to agent  tally fruits for agent }
      end  # the trial is over after the first bite
    }
  }

  observe {
    window ahead 1, behind 1, left 4, right 4
    show tree as { tree }
  }
  metrics { event fruits }
  look tree as green tree

  variant told "sees which tree bears fruit" { observe { show tree as { bare where tree.bears is nothing, laden } } }
}
