sj 1
game stag_hunt "Stag Hunt in the matrix: Arena" extends "pd_arena.sj" {
  cite "Agapiou et al. 2022"
  about summary "Players gather two resources, stag and hare, and meet by beam: a stag hunt is played with the mixture each carries."
                "Two who hunt stag earn most, but who hunts stag alone earns nothing; hare pays a little, whoever one meets."
  drop paradigm  drop long_term_impact  drop multi_task  drop difficulty  drop our_difficulty  # those of the other payoff
  drop socialjax                  # it was not released
  about our_paradigm "stag hunt"  # Melting Pot

  param payoff : reward = { stag: { stag: 4, hare: 0 }, hare: { stag: 2, hare: 2 } }  # Melting Pot
  kind patch "C" {  # on the arena's map `C` is a stag, `D` a hare
    field class : { stag, hare } = stag  glyph "D" with class = hare
    field stock : { none, ripe } = ripe
  }
  agents { field bag by { stag, hare } : 0 .. room capped = 0 }
  metrics { event collected by { stag, hare } }
  checks class {
    require stag_hunt(payoff)  # R > T >= P > S
    expect collected[stag] > collected[hare] with seek patch where patch.class is stag and patch.stock is ripe over 30 episodes
  }
  look patch where patch.class is stag                         as "#e6d5c3"
  look patch where patch.class is hare                         as "#d5e4ea"
  look patch where patch.class is stag and patch.stock is ripe as brown animal
  look patch where patch.class is hare and patch.stock is ripe as white animal
  look agent where agent.bag[stag] > agent.bag[hare]           with brown animal
  look agent where agent.bag[hare] > agent.bag[stag]           with white animal
  policy cooperator "gathers stag alone, and then meets whoever is nearest" {
    aim reach at agent as other where meets(agent, other, stag) avoiding patch where patch.class is hare choose interact
    seek patch where patch.class is stag and patch.stock is ripe avoiding patch where patch.class is hare
  }
  policy defector "gathers hare alone, and then meets whoever is nearest" {
    aim reach at agent as other where meets(agent, other, hare) avoiding patch where patch.class is stag choose interact
    seek patch where patch.class is hare and patch.stock is ripe avoiding patch where patch.class is stag
  }
}
