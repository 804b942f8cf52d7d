sj 1
game fruit_market "Fruit Market: Concentric Rivers" {
  cite "Agapiou et al. 2022"
  about summary "Half of the players are good at picking apples and prefer bananas, the others the reverse. They can offer some fruit for"
                "some of the other kind, and who is near with an offer that fits trades. Walking, wading and hunger tire."
  about our_paradigm "trade"                           # ours: both sides gain by each deal, and bargain over its terms
  size players : count = 16 in 2 .. 16  param length : steps = 1000  episode length  # Melting Pot; half of the players pick apples
  size vigour : count = 18  size cap : count = 255     # Melting Pot: stamina at most; ours: of one fruit, there without end
  param liked : reward = 8  param common : reward = 1  # Melting Pot: for the fruit one is bad at picking; for the other
  param apples : probability = 0.05 in 0 .. 0.5  param bananas : probability = 0.05 in 0 .. 0.5  # Melting Pot: of all ground
  param skill : probability = 0.04                     # Melting Pot: that a step picks the fruit one is bad at; the other is picked at once
  param yield : count = 2 in 0 .. 9  param regrow : steps = 50  # Melting Pot: fruits from a tree, and until it bears again
  param fasting : steps = 50 in 0 .. 255               # Melting Pot: then hunger tires
  param weary : steps = 2 in 0 .. 255  param worn : steps = 6 in 0 .. 255  # Melting Pot: rest after a step with little, with no stamina
  kind ground "." {
    field tree : { none, apple, banana } = none  field fruit : { ripe, unripe } = ripe
    field start : { no_, yes_ } = no_  glyph "P" with start = yes_  timer growing
  }
  kind water "~"  map "maps/fruit_market.txt"

  agents players {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, eat({ apple, banana }), offer(for_ : { apple, banana },
        asks : 1 .. 2, pays : 1 .. 3), cancel, hold, shove, pull  # Melting Pot
    moves relative  field farms : { apple, banana } = apple                           # what it picks at once
    field bag by { apple, banana } : 0 .. cap capped = 0
    field wants : { none, apple, banana } = none  field asks : 0 .. 2 = 0  field pays : 0 .. 3 = 0  # its offer
    field stamina : 0 .. vigour capped = vigour  field stride : { even, odd } = even  # Melting Pot: every second step costs stamina
    timer hunger  timer tired  timer held  timer busy
    forbid turn_left, turn_right, step_left, step_right, forward, backward when agent.tired > 0 or agent.held > 0 or agent.busy > 0
    forbid hold, shove, pull when agent.held > 0
  }
  define walks(a)    = a chose forward or a chose backward or a chose step_left or a chose step_right
  define price(a)    = case a.wants { banana: apple, otherwise: banana }                 # what it pays with
  define stands(a)   = a.wants is not none and a.bag[price(a)] >= a.pays
  define fits(a, b)  = stands(a) and stands(b) and a.wants is price(b) and b.wants is price(a) and a.asks <= b.pays and b.asks <= a.pays
  define beats(b, c) = b.asks <= c.asks and b.pays >= c.pays and (b.asks < c.asks or b.pays > c.pays)
  define best(a, b) = count(agent as c in disc(4) of a where fits(a, c) and beats(c, b)) == 0  shape arm = line(2)  # Melting Pot
  define heard(a, b) = stands(b) and count(agent as c in disc(4) of a where c is b) > 0  # Melting Pot: offers that can be paid, near by
  define grips(a)    = a chose hold or a chose shove or a chose pull

  phase start {
    each agent {
      send agent to ground where ground.start is yes_
      set agent.hunger = fasting  when agent.index * 2 >= players { set agent.farms = banana }  # Melting Pot
    }
    each ground { draw kind_ from { apple: apples, banana: bananas, none: 1 - apples - bananas }  set ground.tree = kind_ }
  }
  schedule bargain -> dine(apple) -> dine(banana) -> walk -> grip -> starve -> exert -> wade -> tick -> tire -> ripen -> pick_fruit -> trade
  phase bargain {
    each agent as a where a chose offer { set a.wants = a.offer.for_  set a.asks = a.offer.asks  set a.pays = a.offer.pays }
    each agent as a where a chose cancel { set a.wants = none }
  }
  phase dine(fruit) {
    each agent as a where a chose eat(fruit) and a.bag[fruit] > 0 {
      add -1 to a.bag[fruit]  set a.hunger = fasting  give case a.farms is fruit { yes: common, no: liked } to a  tally eaten[fruit] for a
    }
  }
  phase grip {
    each agent as a where grips(a) { mark arm of a }
    match agent as a with first agent as b in arm of a where grips(a) {
      set a.busy = 2  set b.held = 2  # Melting Pot: they cannot walk in the next step
      when a chose shove { send b by 1 a.heading facing same otherwise stay }
      otherwise when a chose pull { send b by 1 toward a facing same otherwise stay }
    }
  }
  phase starve { each agent where agent.hunger == 0 { add -1 to agent.stamina } }
  phase exert {  # nobody rests or tires further while it cannot walk
    each agent as a where a.tired == 0 and walks(a) {
      set a.stride = case a.stride { even: odd, odd: even }  when a.stride is odd { add -1 to a.stamina }
    }
    each agent as a on ground where a.tired == 0 and not walks(a) and ground.tree is none { add 1 to a.stamina }
    each agent as a on water where a.tired == 0 and not walks(a) { add 1 to a.stamina }
  }
  phase walk { move each agent }  phase wade { each agent on water { add -1 to agent.stamina } }
  phase tire {
    each agent as a where walks(a) {
      when a.stamina == 0 { set a.tired = worn } otherwise when a.stamina < 7 { set a.tired = weary }  # Melting Pot
    }
  }
  phase ripen { each ground where ground.fruit is unripe and ground.growing == 0 { set ground.fruit = ripe } }
  phase pick_fruit {  # Melting Pot: by who stands on a ripe tree, also if it has ripened under them
    each agent as a on ground as tree where tree.tree is not none and tree.fruit is ripe {
      chance case tree.tree is a.farms { yes: 1, no: skill } {
        set tree.fruit = unripe  set tree.growing = regrow + 1  tally picked for a
        add yield to a.bag[case tree.tree { banana: banana, otherwise: apple }]
      }
    }
  }
  phase trade {  # both get what they ask for
    match agent as a with agent as b in disc(4) of a where fits(a, b) and best(a, b) and best(b, a) {  # Melting Pot
      add a.asks to a.bag[price(b)]  add -1 * b.asks to a.bag[price(a)]  set a.wants = none  tally trades for a
      add b.asks to b.bag[price(a)]  add -1 * a.asks to b.bag[price(b)]  set b.wants = none  tally trades for b
    }
  }
  look ground where ground.tree is apple as tree  look ground where ground.tree is banana as "#a8962a" tree
  look ground where ground.tree is apple and ground.fruit is ripe   with red apple
  look ground where ground.tree is banana and ground.fruit is ripe  with banana
  look ground where ground.tree is apple and ground.fruit is unripe as tree
  observe {
    window ahead 9, behind 1, left 5, right 5  # Melting Pot
    show agent.farms  show agent.bag  show agent.wants  show agent.asks  show agent.pays  show agent.stamina  show agent.hunger
    show agent.held as { held where agent.held > 0, free }  show other.held as { held where other.held > 0, free }
    show other.wants as {
      apple where heard(agent, other) and other.wants is apple, banana where heard(agent, other) and other.wants is banana, none }
    show other.asks as { two where heard(agent, other) and other.asks == 2, one where heard(agent, other), none }
    show other.pays as {
      three where heard(agent, other) and other.pays == 3,
      two where heard(agent, other) and other.pays == 2,
      one where heard(agent, other),
      none }
    show other.farms  show other.stamina  hide ground.start
  }
  metrics { event eaten by { apple, banana }  event picked  event trades }
  define carried = sum(agent.bag[apple] + agent.bag[banana] over agent)
  checks {
    symmetric agents  require apples + bananas <= 1  require liked > common  # there is something to trade
    conserved count(ground where ground.tree is not none)
    always carried + eaten[apple] + eaten[banana] <= yield * picked          # fruit comes from trees alone
    always trades % 2 == 0  expect trades == 0 with never(offer) over 3 episodes  expect trades > 0 with cooperator over 1 episodes
  }
  define mine(a) = a.bag[a.farms]
  policy cooperator "picks what it is good at, gives one for one, and eats what it likes" {
    when agent.farms is apple and agent.bag[banana] > 0 choose eat(banana)
    when agent.farms is banana and agent.bag[apple] > 0 choose eat(apple)
    when agent.wants is none and agent.farms is apple and mine(agent) > 0 choose offer(banana, 1, 1)
    when agent.wants is none and agent.farms is banana and mine(agent) > 0 choose offer(apple, 1, 1)
    seek agent as other where mine(agent) > 2 * yield and other.farms is not agent.farms and mine(other) > 0
    seek ground where ground.tree is agent.farms and ground.fruit is ripe and nobody on ground
  }
  policy defector "eats what it picks, and never trades" {
    when agent.bag[apple] > 0 choose eat(apple)  when agent.bag[banana] > 0 choose eat(banana)
    seek ground where ground.tree is agent.farms and ground.fruit is ripe and nobody on ground
  }
}
