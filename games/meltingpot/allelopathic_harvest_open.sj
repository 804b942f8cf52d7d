sj 1
game allelopathic_harvest_open "Allelopathic Harvest: Open" {
  cite "Koester et al. 2020; Agapiou et al. 2022; allelopathic_harvest of Melting Pot 2"
  about summary "Berries of three colours ripen, each the faster the more bushes of its colour there are. A field of one colour feeds"
                "everybody best; but half of the players like red and half like green, and who replants does not eat meanwhile."
  about our_paradigm "commons"  # ours: replanting costs the planter and serves all

  size players : count = 16 in 2 .. 64                   # Melting Pot
  size strikes : count = 2                               # Melting Pot: hits within `recovery` that send away
  param length : steps = 2000  episode length            # Melting Pot
  param growth   : probability = 0.000005 in 0 .. 0.001  # Melting Pot: that a berry ripens, for each bush of its colour
  param patience : steps       = 10                      # Melting Pot: a berry takes at least as long
  param liked : reward = 2  param disliked : reward = 1  # Melting Pot: for a berry of the colour one likes; for any other
  param certain  : probability = 1                       # Melting Pot: times the share of other colours: eating takes one's coat
  param loading  : steps       = 1 in 0 .. 255           # Melting Pot: until one can sow again
  param cooling  : steps       = 4 in 0 .. 100           # Melting Pot: until one can zap again
  param frozen   : steps       = 24 in 1 .. 100          # Melting Pot: 25, with the step of the zap
  param recovery : steps       = 49                      # Melting Pot: until hits are forgotten
  param penalty  : reward      = -10                     # Melting Pot: the cost of being sent away
  size  absence  : steps       = 27 in 0 .. 1000         # Melting Pot: 25, and it leaves and comes back a step later

  kind floor "."
  kind bush  "1" {
    field colour : { red, green, blue } = red  glyph "2" with colour = green  glyph "3" with colour = blue
    field fruit : { unripe, ripe } = unripe  # Melting Pot: all are unripe at first
    timer young
    blocks seeds                             # Melting Pot: they fall on the first bush
  }
  map wraps "maps/allelopathic_harvest_open.txt"  # Melting Pot

  agents players {
    acts stay, forward, backward, step_left, step_right, turn_left, turn_right, zap, sow_red, sow_green, sow_blue  # Melting Pot
    moves relative  blocks seeds
    field taste : { red, green } = red
    field bag   : { red, green, blue } = red         # the colour last sown
    field coat  : { none, red, green, blue } = none  # the colour last planted: everybody sees it
    field fed   : { no, yes } = no                   # has it eaten on this bush since it came?
    field hits : 0 .. strikes capped = 0  timer recovering  timer stunned  timer hot  timer empty
    forbid zap when agent.hot > 0  forbid sow_red, sow_green, sow_blue when agent.empty > 0
    forbid forward, backward, step_left, step_right, turn_left, turn_right when agent.stunned > 0  # Melting Pot: who is stunned can sow
  }
  shape seeds = line(3)  shape zap = fan(3, 1)  # Melting Pot
  define bushes(hue) = count(bush where bush.colour is hue)
  define share(hue)  = count(bush where bush.colour is hue) / count(bush)
  define commonest   = max(bushes(red), bushes(green), bushes(blue))
  define alike(b)    = case b.colour { red: bushes(red), green: bushes(green), blue: bushes(blue) }
  define sows(one)   = one chose sow_red or one chose sow_green or one chose sow_blue

  phase start {
    each agent { send agent to floor  when 2 * agent.index >= players { set agent.taste = green } }  # Melting Pot
    each bush { set bush.young = patience }
  }

  schedule tick -> ripen -> walk -> eat -> sow(sow_red, red) -> sow(sow_green, green) -> sow(sow_blue, blue) -> plant -> fire -> judge

  phase ripen { each bush as b where b.fruit is unripe and b.young == 0 { chance growth * alike(b) { set b.fruit = ripe } } }
  phase walk { move each agent }
  phase eat {  # Melting Pot: who enters, or stands where a berry ripens; but each only once on a bush, until it leaves it
    each agent on bush {
      when bush.fruit is ripe and (agent.moved or agent.fed is no) {
        set bush.fruit = unripe  set bush.young = patience  set agent.fed = yes  tally eaten[bush.colour] for agent
        give case bush.colour is agent.taste { yes: liked, no: disliked } to agent
        chance certain * (1 - max(share(red), share(green), share(blue))) { set agent.coat = none }
      } otherwise when agent.moved { set agent.fed = no }
    }
  }
  phase sow(deed, hue) { each agent where agent chose deed { mark seeds of agent  set agent.bag = hue  set agent.empty = loading } }
  phase plant {
    match agent as sower with first bush in seeds of sower where sows(sower) and bush.fruit is unripe and bush.colour is not sower.bag {
      set bush.colour = sower.bag  set bush.young = patience  set sower.coat = sower.bag  tally planted[sower.bag] for sower
    }
  }
  phase fire {
    each agent as zapper where zapper chose zap {
      mark zap of zapper  set zapper.hot = cooling
      first agent as victim in zap of zapper { add 1 to victim.hits  set victim.stunned = frozen  set victim.recovering = recovery }
    }
  }
  phase judge {
    each agent as a where a.stunned == frozen { set a.hot = frozen + cooling + 1 }  # Melting Pot: the zapper cools when all is over
    each agent as a where a.hits == strikes {
      set a.hits = 0  set a.coat = none  set a.stunned = 0  give penalty to a  send a to floor after absence  tally banished for a
    }
    each agent as a where a.hits < strikes and a.recovering == 0 { set a.hits = 0 }
  }

  look bush where bush.colour is red                          as red tree
  look bush where bush.colour is green                        as green tree
  look bush where bush.colour is blue                         as blue tree
  look bush where bush.colour is red and bush.fruit is ripe   as red apple
  look bush where bush.colour is green and bush.fruit is ripe as green apple
  look bush where bush.colour is blue and bush.fruit is ripe  as blue apple

  observe {
    window ahead 9, behind 1, left 5, right 5  # Melting Pot
    show other.coat  show other.hits  show agent.coat  show agent.hits  show agent.taste  show agent.hot
  }
  metrics { event eaten by { red, green, blue }  event planted by { red, green, blue }  event banished  mean commonest = commonest }
  checks {
    symmetric agents
    expect banished == 0 with never(zap) over 10 episodes
    require liked > disliked
    expect planted[red] == 0 with never(sow_red) over 10 episodes
  }
  policy planter "sows red at the next bush that is unripe and not red" {
    aim seeds at bush where bush.fruit is unripe and bush.colour is not red choose sow_red
  }
  policy eater "eats the nearest berry" { seek bush where bush.fruit is ripe }
}
