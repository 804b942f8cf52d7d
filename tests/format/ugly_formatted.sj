# A game that nobody laid out.

sj 1                                # the language
game ugly "Nobody laid this out" {  # its block opens here
  cite "nobody"
  about summary "first line of it"
                "second line of it"
  size  players : count       = 3 in 2 .. 6  # how many
  param length  : steps       = 10
  param payoff  : reward      = {
    coop: { coop: 3, defect: -1 },  # rows are what the row player did

    defect: { coop: 5, defect: 1 } } in -5 .. 5  # both
  param rate    : probability = case_rate(1) / 2  #source
  episode length

  kind floor "."  kind wall "#" { blocks agents, beam }
  kind tree "T" {
    field fruit : { none, ripe } = ripe  field owner : agent = nobody
    timer resting
  }
  kind gate  # where they come in
      "P"
  map { "TTT#"
        "P..P"  # here they start
        ".PP."
  }
  agents players {
    acts turn_left, turn_right, forward, backward, stay, zap, a_long_action_name, another_long_action_name, yet_another_long_action_name
    moves relative
  }
  shape beam { ".x."
               "xxx"
               ".^." }
  define near(a, b) = count(agent in disc(1) of a) > 0 and not (b.fruit is none) or -1 < -(2)
  define dirt       = count(tree where tree.fruit is none) / count(tree)

  phase start { each agent { send agent to gate facing north otherwise stay } }
  schedule tick -> grow(ripe) -> walk -> a_phase_with_a_long_name -> another_phase_with_a_long_name -> yet_another_phase
      -> the_last_phase_of_them_all
  phase grow(what) {  # trees
    # on their own line
    each tree where tree.fruit is none and nobody on tree {
      chance case near { 0: 0, 1 .. 2: 0.01, 3..: 0.025, otherwise: 1 } { set tree.fruit = what } otherwise { end }
    }
  }
  phase walk { move each agent }
  phase a_phase_with_a_long_name {
    each agent where agent chose zap { mark beam of agent  each agent as victim in beam of agent { remove victim } }
  }
  phase another_phase_with_a_long_name {
    when step > 3 {
      set a = 1  set b = 2
    } otherwise when step > 2 { give payoff[coop][defect] to all but agent  tally met by 2 for agent }
    # the last of them, with a comment that is so long that there is no room for it behind the sentence that it is about
    otherwise { give 1 to agent }
    draw colour from { red: 0.25, green: 1 - 0.25 }
    let level = sum(agent.bag[raw] + agent.bag[cut] over agent
        where agent.index > 0) * (1 + 2) / 3 - lowest(agent.bag) + highest(agent.bag) - sum(agent.bag)
  }
  # Comments can be as long as their authors like, and go on and on; but a line that is longer than one hundred and forty columns is not
  # easy to read on a screen.
  observe { window ahead (1 + 2), behind 1, left 0, right 0  show tree.fruit as { mine where tree.owner is agent, none } }
  checks {
    require -1 < 0  expect eaten > 0 with random, never(zap), seek tree where tree.fruit is ripe over 30 episodes
    # the end of the checks
  }  # behind a brace
  variant other "another" { agents { moves compass }  drop crowd  set payoff[coop][coop] = 2 }
}
# after all
