sj 1
# One of two trees bears fruit, and which one is hidden. It stays the same in all five trials of an episode, so an agent that
# remembers what it tried in the first trial knows where to go in the others.
#
# Fruits in trials 0 to 4, mean of 500 episodes and of seeds 1 to 3 (a minute a seed on one core):
#   0.49  0.90  0.97  0.98  0.98   with memory: sjdsl train examples/two_trees.sj --preset examples/two_trees.toml --seed 1
#   0.50  0.49  0.49  0.49  0.49   without: --preset two_cores --reward individual --set total_timesteps=4e5 --set num_steps=50
#                                  --set num_minibatches=4 --set learning_rate=2e-3 --set network_width=32
#   1     1     1     1     1      the first command with --variant told: the agent sees which tree bears fruit
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
  look tree                           as green tree
  look tree where tree.bears is fruit as green tree with red apple  # for us: no agent sees it

  variant told "sees which tree bears fruit" { observe { show tree as { bare where tree.bears is nothing, laden } } }
}
