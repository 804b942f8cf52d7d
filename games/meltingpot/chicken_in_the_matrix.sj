sj 1
game chicken_in_the_matrix "Chicken in the Matrix" extends "prisoners_dilemma_in_the_matrix.sj" {
  cite "Agapiou et al. 2022; the_matrix of Melting Pot 2"
  about summary "Players gather doves and hawks, and challenge each other with a beam: the mixture that each of the two holds is its"
                "strategy. A hawk takes most from a dove, but two hawks get nothing."
  about our_paradigm "chicken"  # Melting Pot

  set ending = 0.2  # Melting Pot
  param payoff : reward = { dove: { dove: 3, hawk: 2 }, hawk: { dove: 5, hawk: 0 } }  # Melting Pot
  set edge_1 = 1.5  set edge_2 = 2.5  set edge_3 = 3.5  set edge_4 = 5                # Melting Pot: colours

  kind patch "1" {
    field class : { dove, hawk } = dove  glyph "2" with class = hawk
    field sort : { fixed, drawn } = fixed  glyph "a" with sort = drawn  # Melting Pot: any of the classes, in each episode
    field stock  : { none, ripe } = ripe
    field damage : 0 .. health capped = 0
    timer young
    blocks beam when patch.stock is ripe and patch.damage + 1 < health  # Melting Pot: beams go on through what they destroy
  }
  agents {
    field bag by { dove, hawk } : 0 .. room capped = 1
    field brought by { dove, hawk } : 0 .. room = 0  field faced by { dove, hawk } : 0 .. room = 0
  }
  phase start {
    each agent { send agent to gate  set agent.badge = agent.index + 1 }
    each patch where patch.sort is drawn { draw hue from { dove, hawk }  set patch.class = hue }
  }
  metrics { event collected by { dove, hawk }  event destroyed by { dove, hawk } }
  observe { show patch as { dove where patch.stock is ripe and patch.class is dove, hawk where patch.stock is ripe, floor } }
  look patch where patch.stock is ripe and patch.class is dove as green gem
  look patch where patch.stock is ripe and patch.class is hawk as red gem
  checks class { require chicken(payoff) }
  policy cooperator "gathers dove, and challenges whoever is nearest" {
    aim beam at agent as other where meets(agent, other, dove) choose interact
    seek patch where patch.class is dove and patch.stock is ripe avoiding patch where patch.class is hawk
  }
  policy defector "gathers hawk, and challenges whoever is nearest" {
    aim beam at agent as other where meets(agent, other, hawk) choose interact
    seek patch where patch.class is hawk and patch.stock is ripe avoiding patch where patch.class is dove
  }
}
