sj 1
game stag_hunt_in_the_matrix "Stag Hunt in the Matrix" extends "prisoners_dilemma_in_the_matrix.sj" {
  cite "Agapiou et al. 2022; the_matrix of Melting Pot 2"
  about summary "Players gather stags and hares, and challenge each other with a beam: the mixture that each of the two holds is its"
                "strategy. Two stags pay most, one stag alone nothing; hares pay a little, and there are more of them."
  about our_paradigm "stag hunt"  # Melting Pot

  set ending = 0.1  # Melting Pot
  param payoff : reward = { stag: { stag: 4, hare: 0 }, hare: { stag: 2, hare: 2 } }  # Melting Pot
  set edge_1 = 0.5  set edge_2 = 1.5  set edge_3 = 2.5  set edge_4 = 3.5              # Melting Pot: colours

  kind patch "1" {
    field class : { stag, hare } = stag  glyph "2" with class = hare
    field sort : { fixed, drawn } = fixed  glyph "a" with sort = drawn  # Melting Pot: any of the classes, in each episode
    field stock  : { none, ripe } = ripe
    field damage : 0 .. health capped = 0
    timer young
    blocks beam when patch.stock is ripe and patch.damage + 1 < health  # Melting Pot: beams go on through what they destroy
  }
  map "maps/stag_hunt_arena.txt"  # Melting Pot
  agents {
    field bag by { stag, hare } : 0 .. room capped = 1
    field brought by { stag, hare } : 0 .. room = 0  field faced by { stag, hare } : 0 .. room = 0
  }
  phase start {
    each agent { send agent to gate  set agent.badge = agent.index + 1 }
    each patch where patch.sort is drawn { draw hue from { stag, hare }  set patch.class = hue }
  }
  metrics { event collected by { stag, hare }  event destroyed by { stag, hare } }
  observe { show patch as { stag where patch.stock is ripe and patch.class is stag, hare where patch.stock is ripe, floor } }
  look patch where patch.stock is ripe and patch.class is stag as brown animal
  look patch where patch.stock is ripe and patch.class is hare as white animal
  checks class { require stag_hunt(payoff) }
  policy cooperator "gathers stag, and challenges whoever is nearest" {
    aim beam at agent as other where meets(agent, other, stag) choose interact
    seek patch where patch.class is stag and patch.stock is ripe avoiding patch where patch.class is hare
  }
  policy defector "gathers hare, and challenges whoever is nearest" {
    aim beam at agent as other where meets(agent, other, hare) choose interact
    seek patch where patch.class is hare and patch.stock is ripe avoiding patch where patch.class is stag
  }
  variant repeated "Two players meet again and again; all resources are back when both are away" {
    set players = 2  set absence = 6  set longest = 2500  set ending = 0.1  set regrow = 0.02  # Melting Pot
    map "maps/stag_hunt_repeated.txt"  # Melting Pot
    observe { window ahead 3, behind 1, left 2, right 2  hide other.badge }                    # Melting Pot
    schedule walk -> tick -> collect -> aim -> wreck -> meet -> refill -> settle -> grow -> sign -> close
    phase refill { when count(agent) == 0 { each patch { set patch.stock = ripe } } }
  }
}
