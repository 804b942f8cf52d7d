sj 1
game chicken "Chicken in the matrix: Arena" extends "pd_arena.sj" {
  cite "Agapiou et al. 2022"
  about summary "Players gather two resources, dove and hawk, and meet by beam: a game of chicken is played with the mixture each"
                "carries. A hawk takes most from a dove, but two hawks get nothing: one does best not to be what the others are."
  drop paradigm  drop long_term_impact  drop multi_task  drop difficulty  drop our_difficulty  # those of the other payoff
  drop socialjax                # it was not released
  about our_paradigm "chicken"  # Melting Pot

  param payoff : reward = { dove: { dove: 3, hawk: 2 }, hawk: { dove: 5, hawk: 0 } }  # Melting Pot
  kind patch "C" {  # on the arena's map `C` is a dove, `D` a hawk
    field class : { dove, hawk } = dove  glyph "D" with class = hawk
    field stock : { none, ripe } = ripe
  }
  agents { field bag by { dove, hawk } : 0 .. room capped = 0 }
  metrics { event collected by { dove, hawk } }
  checks class {
    require chicken(payoff)  # T > R > S > P
    expect collected[dove] > collected[hawk] with seek patch where patch.class is dove and patch.stock is ripe over 30 episodes
  }
  look patch where patch.class is dove                         as "#d5e4ea"
  look patch where patch.class is hawk                         as "#f3e0bd"
  look patch where patch.class is dove and patch.stock is ripe as sky gem
  look patch where patch.class is hawk and patch.stock is ripe as red mushroom
  look agent where agent.bag[dove] > agent.bag[hawk]           with sky gem
  look agent where agent.bag[hawk] > agent.bag[dove]           with red mushroom
  policy cooperator "gathers dove alone, and then meets whoever is nearest" {
    aim reach at agent as other where meets(agent, other, dove) avoiding patch where patch.class is hawk choose interact
    seek patch where patch.class is dove and patch.stock is ripe avoiding patch where patch.class is hawk
  }
  policy defector "gathers hawk alone, and then meets whoever is nearest" {
    aim reach at agent as other where meets(agent, other, hawk) avoiding patch where patch.class is dove choose interact
    seek patch where patch.class is hawk and patch.stock is ripe avoiding patch where patch.class is dove
  }
}
