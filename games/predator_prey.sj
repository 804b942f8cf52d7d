sj 1
game predator_prey "Predator and Prey: Open" {
  cite "Agapiou et al. 2022"
  about summary "Prey gather apples and acorns, predators eat prey. Prey that stand together are safe if there are more of them than"
                "predators around; but who strays alone finds more food. Tall grass keeps predators out."
  about our_paradigm "stag hunt"   # ours: safety needs company, food tempts away from it
  about our_long_term_impact "no"  # ours: the field grows back, whatever was done
  about our_multi_task "yes"       # ours: gathering and guarding

  size  players : count       = 13 in 2 .. 34  # Melting Pot
  size  hunters : count       = 3 in 1 .. 33   # Melting Pot: the first agents are predators
  size  company : cells       = 3              # Melting Pot: how far away others count
  param length  : steps       = 1000           # ours: as in the other games
  param apple   : reward      = 1              # Melting Pot
  param acorn   : reward      = 18             # Melting Pot
  param meal    : reward      = 1              # Melting Pot: for the predator that eats it
  param chewing : steps       = 26             # Melting Pot: an acorn takes this long
  param rest    : steps       = 5              # Melting Pot: of a predator that has eaten
  param apples  : probability = 0.007          # Melting Pot: that one grows, per empty tree and step
  param acorns  : probability = 0.01           # Melting Pot: the same for oaks
  size  absence : steps       = 200            # Melting Pot: of one who was eaten
  episode length

  kind floor "."
  kind wall  "#" { blocks agents }
  kind grass "g" { blocks agents when agent.role is predator }
  kind nest  "P" { blocks agents when agent.role is predator }  # grass, too
  kind lair  "X"
  kind tree  "a" { field fruit : { none, ripe } = ripe }
  kind oak   "n" { field fruit : { none, ripe } = ripe }
  map "maps/predator_prey.txt"

  agents players {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, bite
    moves relative
    field role  : { prey, predator } = prey
    field mouth : { empty, holding, eating } = empty
    timer chews
    timer resting
    forbid all when agent.mouth is eating or agent.resting > 0
  }
  shape jaws = line(1)  # Melting Pot
  define hunters_near(one) = count(agent as a in disc(company, centre) of one where a.role is predator)
  define prey_near(one)    = count(agent as a in disc(company, centre) of one where a.role is prey and a.mouth is not eating)

  phase start {
    each agent { when agent.index < hunters { set agent.role = predator  send agent to lair } otherwise { send agent to nest } }
  }

  schedule grow -> tick -> walk -> gather -> eat -> hunt

  phase grow {
    each tree where tree.fruit is none and nobody on tree { chance apples { set tree.fruit = ripe } }
    each oak where oak.fruit is none and nobody on oak { chance acorns { set oak.fruit = ripe } }
  }
  phase walk { move each agent }
  phase gather {
    each agent on tree where agent.role is prey and tree.fruit is ripe {
      set tree.fruit = none  give apple to agent  tally apples_eaten for agent
    }
    each agent on oak where agent.role is prey and agent.mouth is empty and oak.fruit is ripe {
      set oak.fruit = none  set agent.mouth = holding
    }
  }
  phase eat {  # prey bite into what they hold
    each agent where agent.mouth is holding and agent chose bite { set agent.mouth = eating  set agent.chews = chewing }
    each agent where agent.mouth is eating and agent.chews == 0 {
      set agent.mouth = empty  give acorn to agent  tally acorns_eaten for agent
    }
  }
  phase hunt {
    each agent as hunter where hunter.role is predator and hunter chose bite { mark jaws of hunter }
    match agent as hunter with first agent as target in jaws of hunter where hunter.role is predator and hunter chose bite
        and (target.role is predator or prey_near(target) <= hunters_near(target)) {
      set hunter.resting = rest
      set target.mouth = empty
      when target.role is predator { send target to lair after absence }
      otherwise { send target to nest after absence  give meal to hunter  tally caught for hunter  tally eaten for target }
    }
  }

  look oak                                            as "#6b7a2e" tree
  look oak where oak.fruit is ripe                    with brown apple
  look agent where agent.role is prey                 as sky
  look agent where agent.role is predator             as red animal
  look agent where agent.mouth in { holding, eating } with brown apple

  observe {
    window ahead 9, behind 1, left 5, right 5  # Melting Pot
    show agent.role  show agent.mouth  show other.role  show other.mouth
  }
  metrics { event apples_eaten  event acorns_eaten  event caught  event eaten  mean apples_left = count(tree where tree.fruit is ripe) }
  checks {
    symmetric agents
    require acorn > apple
    expect caught == 0 with never(bite) over 10 episodes
    always caught == eaten
  }
}
