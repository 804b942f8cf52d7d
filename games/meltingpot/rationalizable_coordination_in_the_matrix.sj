sj 1
game rationalizable_coordination_in_the_matrix "Rationalizable Coordination in the Matrix" extends "running_with_scissors_in_the_matrix.sj"
    {
  cite "Agapiou et al. 2022; the_matrix of Melting Pot 2"
  about summary "Players gather three colours, and challenge each other with a beam: the mixture that each of the two holds is its"
                "strategy. Two who have gathered the same colour are paid: for blue most, for red least."
  about our_paradigm "coordination"  # Melting Pot

  param payoff : reward = {  # Melting Pot
    red:   { red: 1, green: 0, blue: 0 },
    green: { red: 0, green: 2, blue: 0 },
    blue:  { red: 0, green: 0, blue: 3 } }
  set edge_1 = 0.5  set edge_2 = 1.5  set edge_3 = 2.5  set edge_4 = 3  # Melting Pot: colours
  kind patch "1" {
    field class : { red, green, blue } = red  glyph "2" with class = green  glyph "3" with class = blue
    field sort : { fixed, drawn } = fixed  glyph "a" with sort = drawn  # Melting Pot: any of the classes, in each episode
    field stock  : { none, ripe } = ripe
    field damage : 0 .. health capped = 0
    timer young
    blocks beam when patch.stock is ripe and patch.damage + 1 < health  # Melting Pot: beams go on through what they destroy
  }
  agents {
    field bag by { red, green, blue } : 0 .. room capped = 1
    field brought by { red, green, blue } : 0 .. room = 0  field faced by { red, green, blue } : 0 .. room = 0
  }
  phase start {
    each agent { send agent to gate  set agent.badge = agent.index + 1 }
    each patch where patch.sort is drawn { draw hue from { red, green, blue }  set patch.class = hue }
  }
  metrics { event collected by { red, green, blue }  event destroyed by { red, green, blue } }
  observe {
    hide other.badge  # Melting Pot: all others look alike
    show patch as {
      red where patch.stock is ripe and patch.class is red, green where patch.stock is ripe and patch.class is green,
      blue where patch.stock is ripe, floor }
  }
  look patch where patch.stock is ripe and patch.class is red   as red gem
  look patch where patch.stock is ripe and patch.class is green as green gem
  look patch where patch.stock is ripe and patch.class is blue  as blue gem
  drop beats  drop rock  drop paper  drop scissors  drop one_shot
  checks agree { require payoff[blue][blue] > payoff[green][green] and payoff[green][green] > payoff[red][red] }
  policy gatherer "gathers blue, and challenges whoever is nearest" {
    aim beam at agent as other where meets(agent, other, blue) choose interact
    seek patch where patch.class is blue and patch.stock is ripe avoiding patch where patch.class is not blue
  }
  variant repeated "Two players meet again and again; all resources are back when both are away" {
    set players = 2  set absence = 6  set ending = 0.1  set regrow = 0.02  map "maps/matrix_repeated_three.txt"  # Melting Pot
    observe { window ahead 3, behind 1, left 2, right 2 }  # Melting Pot
    schedule walk -> tick -> collect -> aim -> wreck -> meet -> refill -> settle -> grow -> sign -> close
    phase refill { when count(agent) == 0 { each patch { set patch.stock = ripe } } }
  }
}
