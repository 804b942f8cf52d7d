sj 1
game predator_prey_open "Predator and Prey" {
  cite "Agapiou et al. 2022; predator_prey of Melting Pot 2"
  about summary "Prey gather apples, and acorns that take long to eat; predators eat prey that has too few others around it. Whoever"
                "does anything tires, and is slow until it has rested. Tall grass keeps predators out."
  about our_paradigm "stag hunt"  # ours: safety needs company, food tempts away from it

  size players : count = 13 in 2 .. 32  size hunters : count = 3 in 1 .. 31     # Melting Pot: the first agents are predators
  size company : cells = 3  param length : steps = 1000  episode length         # Melting Pot: how far away others count; an episode
  size energy : count = 18  size eager : count = 13                  # Melting Pot: all stamina; enough to eat acorns
  param snack : reward = 1  param nibble : reward = 6  param meal : reward = 1  # Melting Pot: apples; each third of an acorn; prey
  param chewing : steps = 26  size third : steps = 5  # Melting Pot: an acorn takes so long; its thirds end 3, 2 and 1 times 5 before
  param pause : steps = 6 in 0 .. 255                                # Melting Pot: between attempts to eat an acorn
  param hold : steps = 5 in 1 .. 255  param alarm : steps = 5 in 0 .. 255  # Melting Pot: predators that have eaten bite on; prey is alarmed
  size effort : count = 4  size absence : steps = 201  # Melting Pot: stamina that eating a predator takes; of one who was eaten
  param growth : probability = { apple: 0.007, acorn: 0.01 }         # Melting Pot: that one grows, per empty place and step
  param quick  : steps       = { prey: 1, predator: 0 } in 0 .. 200  # Melting Pot: steps without moving after an action, ...
  param slow : steps = { prey: 2, predator: 1 } in 0 .. 200  param spent : steps = { prey: 4, predator: 6 } in 0 .. 200  # Melting Pot
  param maybe : probability = 0.33333                                # Melting Pot: odds of 1 to 2, in Random Forest
  kind floor "." { field home : { none, prey, predator } = none  glyph "P" with home = prey  glyph "X" with home = predator }
  kind wall  "#" { blocks agents }
  kind grass "g" {
    field home : { none, prey, predator } = none  glyph "h" with home = prey  field stands : { yes_, no_ } = yes_
    field sort : { sure, unsure } = sure  glyph "M" with sort = unsure
    blocks agents when agent.role is predator and grass.stands is yes_
  }
  kind tree  "a" {
    field home : { none, prey, predator } = none  glyph "&" with home = prey  field stands : { yes_, no_ } = yes_
    field food : { apple, acorn } = apple  glyph "n" with food = acorn  field fruit : { none, ripe } = ripe
    field sort : { sure, unsure } = sure  glyph "N" with food = acorn with sort = unsure
  }
  group ground = floor, grass, tree  map "maps/predator_prey_open.txt"  # Melting Pot
  agents players {
    acts stay, forward, backward, step_left, step_right, turn_left, turn_right, bite  # Melting Pot: in this order
    moves relative
    field role : { prey, predator } = prey  field hand : { empty, acorn } = empty  field mouth : { empty, eating } = empty
    field badge : 0 .. players = 0  field stamina : 0 .. energy capped = energy  field bar : 0 .. eager = eager  # badge, bar: for others
    field biters : set of agent  field fate : { alive, caught } = alive  timer chews  timer tried  timer busy  timer tired  timer alert
    forbid forward, backward, step_left, step_right, turn_left, turn_right when agent.tired > 1
  }
  shape jaws = line(1)  define bites(who) = who.role is predator and (who chose bite or who.busy > 0)  # Melting Pot
  define guards(who)       = who.role is prey and who.mouth is not eating and who.stamina > 0
  define hunters_near(one) = count(agent as a in disc(company, centre) of one where a.role is predator and a.stamina > 0)
  define prey_near(one)    = count(agent as a in disc(company, centre) of one where guards(a))
  phase start {
    each agent {
      when agent.index < hunters { set agent.role = predator  send agent to ground where ground.home is predator }
      otherwise { set agent.badge = agent.index + 1  send agent to ground where ground.home is prey }
    }
    each grass where grass.sort is unsure { chance 1 - maybe { set grass.stands = no_ } }
    each tree where tree.sort is unsure { chance 1 - maybe { set tree.stands = no_  set tree.fruit = none } }
  }
  schedule tick -> digest -> walk -> grow -> gather -> aim -> hunt -> sit -> tire -> leave
  phase walk { move each agent where agent.busy == 0 }
  phase digest {
    each agent where agent.mouth is eating {
      when agent.chews == third or agent.chews == 2 * third or agent.chews == 3 * third { give nibble to agent }
      when agent.chews == 0 { set agent.mouth = empty  tally acorns for agent }
    }
  }
  phase gather {
    each agent on tree where agent.role is prey and tree.fruit is ripe {
      when tree.food is apple { set tree.fruit = none  give snack to agent  tally apples for agent }
      otherwise when agent.hand is empty { set tree.fruit = none  set agent.hand = acorn }
    }
  }
  phase aim {
    each agent as hunter where bites(hunter) {
      mark jaws of hunter  first agent as target in jaws of hunter { add hunter to target.biters }
    }
  }
  phase hunt {
    each agent as target where target.biters is not nobody {
      when target.role is predator {
        set target.fate = caught  each agent as hunter in target.biters { add -effort to hunter.stamina }
      } otherwise when prey_near(target) <= hunters_near(target) {  # Melting Pot's code: all who bite it are paid
        set target.fate = caught  tally eaten for target
        each agent as hunter in target.biters { set hunter.busy = hold  give meal to hunter  tally caught for hunter }
      } otherwise { each agent as mate in disc(company, centre) of target where guards(mate) { set mate.alert = alarm } }
      set target.biters = nobody
    }
  }
  phase sit {
    each agent where agent.role is prey and agent chose bite and agent.tried == 0 {
      set agent.tried = pause
      when agent.hand is acorn and agent.mouth is empty and agent.stamina >= eager and agent.alert == 0 {
        set agent.hand = empty  set agent.mouth = eating  set agent.chews = chewing
      }
    }
  }
  phase tire {  # Melting Pot: whatever one does
    each agent as a where a.tired == 0 { when a chose stay { add 1 to a.stamina } otherwise { add -1 to a.stamina } }
    each agent as a where a.tired == 0 and not (a chose stay) {
      set a.tired = 1 + case a.stamina { 0 .. 1: spent[a.role], 2 .. 7: slow[a.role], otherwise: quick[a.role] }
    }
  }
  phase leave {
    each agent { set agent.bar = min(agent.stamina, eager) }
    each agent as a where a.fate is caught {
      set a.fate = alive  set a.mouth = empty  set a.stamina = energy
      when a.role is predator { send a to ground where ground.home is predator after absence otherwise stay }
      otherwise { send a to ground where ground.home is prey after absence otherwise stay }
    }
  }
  phase grow { each tree where tree.fruit is none and tree.stands is yes_ { chance growth[tree.food] { set tree.fruit = ripe } } }
  look tree where tree.fruit is ripe and tree.food is apple     as green apple
  look tree where tree.fruit is ripe and tree.food is acorn     as brown apple
  look agent where agent.role is predator                       as red animal
  look agent where agent.hand is acorn or agent.mouth is eating with brown apple
  look grass where grass.stands is no_ as "#eeece7"  look tree where tree.stands is no_ as "#eeece7"
  look tree where tree.stands is no_ as "#eeece7" floor
  observe {
    window ahead 9, behind 1, left 5, right 5  # Melting Pot
    show tree as { apple where tree.fruit is ripe and tree.food is apple, acorn where tree.fruit is ripe, floor }
    show grass as { grass where grass.stands is yes_, floor }
    hide floor.home  hide grass.home  hide tree.home  hide tree.stands
    show agent.role  show agent.hand  show agent.mouth  show agent.stamina  show agent.badge
    show other.role
    show other.hand
    show other.mouth
    show other.bar
    show other.badge
    show other.alert as { alarmed where other.alert > 0, calm }
  }
  metrics { event apples  event acorns  event caught  event eaten }  checks { expect caught == 0 with never(bite) over 10 episodes }
  checks { symmetric agents  always count(agent where (agent.hand is acorn or agent.mouth is eating) and agent.role is predator) == 0 }
  policy gatherer "eats apples" {
    seek tree where tree.food is apple and tree.fruit is ripe avoiding grass where agent.role is predator and grass.stands is yes_
  }
  policy hunter "bites the nearest prey" {
    aim jaws at agent as other where other.role is prey avoiding grass where agent.role is predator and grass.stands is yes_ choose bite
  }
  variant alley_hunt "Apples in a maze of dead ends" { set hunters = 5  map "maps/predator_prey_alley_hunt.txt" }   # Melting Pot
  variant orchard "Apples here, acorns there" { set hunters = 5  map "maps/predator_prey_orchard.txt" }             # Melting Pot
  variant random_forest "Acorns, patches of grass" { set hunters = 5  map "maps/predator_prey_random_forest.txt" }  # Melting Pot
  variant described "Prey cannot move while it eats an acorn, as the description says and the code does not" {
    agents {
      forbid forward, backward, step_left, step_right, turn_left, turn_right when agent.tired > 1 or agent.mouth is eating
    }
  }
}
