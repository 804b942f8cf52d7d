sj 1
game running_with_scissors_in_the_matrix "Running with Scissors in the Matrix" extends "prisoners_dilemma_in_the_matrix.sj" {
  cite "Vezhnevets et al. 2020; Agapiou et al. 2022; the_matrix of Melting Pot 2"
  about summary "Players gather rock, paper and scissors, and challenge each other with a beam: the mixture that each of the two holds"
                "is its strategy. Who sees what another gathers, or destroys it, can answer with what beats it."
  about our_paradigm "zero sum"  # Melting Pot

  set classes = 3  set ending = 0.2  # Melting Pot
  param payoff : reward = {          # Melting Pot
    rock:     { rock: 0, paper: -10, scissors: 10 },
    paper:    { rock: 10, paper: 0, scissors: -10 },
    scissors: { rock: -10, paper: 10, scissors: 0 } }
  set edge_1 = -5  set edge_2 = -2.5  set edge_3 = 2.5  set edge_4 = 5  # Melting Pot: colours
  kind patch "1" {
    field class : { rock, paper, scissors } = rock  glyph "2" with class = paper  glyph "3" with class = scissors
    field sort : { fixed, drawn } = fixed  glyph "a" with sort = drawn  # Melting Pot: any of the classes, in each episode
    field stock  : { none, ripe } = ripe
    field damage : 0 .. health capped = 0
    timer young
    blocks beam when patch.stock is ripe and patch.damage + 1 < health  # Melting Pot: beams go on through what they destroy
  }
  map "maps/matrix_arena_three.txt"  # Melting Pot
  agents {
    field bag by { rock, paper, scissors } : 0 .. room capped = 1
    field brought by { rock, paper, scissors } : 0 .. room = 0  field faced by { rock, paper, scissors } : 0 .. room = 0
  }
  phase start {
    each agent { send agent to gate  set agent.badge = agent.index + 1 }
    each patch where patch.sort is drawn { draw hue from { rock, paper, scissors }  set patch.class = hue }
  }
  metrics { event collected by { rock, paper, scissors }  event destroyed by { rock, paper, scissors } }
  observe {
    show patch as {
      rock where patch.stock is ripe and patch.class is rock, paper where patch.stock is ripe and patch.class is paper,
      scissors where patch.stock is ripe, floor }
  }
  look patch where patch.stock is ripe and patch.class is rock     as yellow gem
  look patch where patch.stock is ripe and patch.class is paper    as purple gem
  look patch where patch.stock is ripe and patch.class is scissors as sky gem
  drop class  drop cooperator  drop defector
  checks beats { require payoff[rock][scissors] > payoff[rock][rock] and payoff[rock][rock] > payoff[rock][paper] }
  policy rock "gathers rock, and challenges whoever is nearest" {
    aim beam at agent as other where meets(agent, other, rock) choose interact
    seek patch where patch.class is rock and patch.stock is ripe avoiding patch where patch.class is not rock
  }
  policy paper "gathers paper, and challenges whoever is nearest" {
    aim beam at agent as other where meets(agent, other, paper) choose interact
    seek patch where patch.class is paper and patch.stock is ripe avoiding patch where patch.class is not paper
  }
  policy scissors "gathers scissors, and challenges whoever is nearest" {
    aim beam at agent as other where meets(agent, other, scissors) choose interact
    seek patch where patch.class is scissors and patch.stock is ripe avoiding patch where patch.class is not scissors
  }
  variant repeated "Two players meet again and again; all resources are back when both are away" {
    # Melting Pot
    set players = 2  set absence = 6  set ending = 0.2  set regrow = 0.02  set delay = 16  map "maps/matrix_repeated_three.txt"
    observe { window ahead 3, behind 1, left 2, right 2  hide other.badge }  # Melting Pot
    schedule walk -> tick -> collect -> aim -> wreck -> meet -> refill -> settle -> grow -> sign -> close
    phase refill { when count(agent) == 0 { each patch { set patch.stock = ripe } } }
  }
  variant one_shot "Two players meet once; what is gathered or destroyed does not come back" {
    set players = 2  set longest = 1000  map "maps/matrix_one_shot.txt"                         # Melting Pot
    observe { window ahead 3, behind 1, left 2, right 2  hide other.badge }                     # Melting Pot
    schedule walk -> tick -> collect -> aim -> wreck -> meet -> settle -> sign
    drop grow  drop close  drop soonest  drop interval  drop ending  drop regrow  drop absence  # nothing comes back
    timer closing
    phase settle {
      each agent where agent.frozen == 1 { give agent.owed to agent  set agent.bag = 1 }
      when count(agent where agent.frozen == 1) > 0 { set closing = 2 } otherwise when closing == 1 { end }  # Melting Pot: a step later
    }
  }
}
