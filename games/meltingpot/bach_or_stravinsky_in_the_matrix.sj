sj 1
game bach_or_stravinsky_in_the_matrix "Bach or Stravinsky in the Matrix" extends "prisoners_dilemma_in_the_matrix.sj" {
  cite "Agapiou et al. 2022; the_matrix of Melting Pot 2"
  about summary "Players gather two kinds of music, and challenge each other with a beam: the mixture that each of the two holds is its"
                "strategy. Fans of Bach meet fans of Stravinsky alone, and each side would rather agree on its own."
  about our_paradigm "bach or stravinsky"  # Melting Pot

  set ending = 0.2  # Melting Pot
  param payoff : reward = { bach: { bach: 3, stravinsky: 0 }, stravinsky: { bach: 0, stravinsky: 2 } }  # Melting Pot: a fan of Bach's
  param theirs : reward = { bach: { bach: 2, stravinsky: 0 }, stravinsky: { bach: 0, stravinsky: 3 } }  # Melting Pot: the other's
  set edge_1 = 0.5  set edge_2 = 1.5  set edge_3 = 2.5  set edge_4 = 3  # Melting Pot: colours

  kind patch "1" {
    field class : { bach, stravinsky } = bach  glyph "2" with class = stravinsky
    field sort : { fixed, drawn } = fixed  glyph "a" with sort = drawn  # Melting Pot: any of the classes, in each episode
    field stock  : { none, ripe } = ripe
    field damage : 0 .. health capped = 0
    timer young
    blocks beam when patch.stock is ripe and patch.damage + 1 < health  # Melting Pot: beams go on through what they destroy
  }
  agents {
    field bag by { bach, stravinsky } : 0 .. room capped = 1
    field brought by { bach, stravinsky } : 0 .. room = 0  field faced by { bach, stravinsky } : 0 .. room = 0
    field fan_of : { bach, stravinsky } = bach
  }
  phase start {
    each agent { send agent to gate  set agent.badge = agent.index + 1  when 2 * agent.index >= players { set agent.fan_of = stravinsky } }
    each patch where patch.sort is drawn { draw hue from { bach, stravinsky }  set patch.class = hue }
  }
  phase aim {
    each agent as row where row chose interact {
      mark beam of row  set row.hot = cooling
      first agent as column in beam of row {
        when can_meet(row) and can_meet(column) and row.fan_of is not column.fan_of { add row to column.rivals }
      }
      each patch in beam of row where patch.stock is ripe { add 1 to patch.damage }
    }
  }
  phase meet {
    match agent as column with agent as row in column.rivals where sum(row.bag) > classes and sum(column.bag) > classes {
      when row.fan_of is bach {
        set row.owed = payoff[mix(row.bag)][mix(column.bag)]
        set column.owed = theirs[mix(row.bag)][mix(column.bag)]
      } otherwise {
        set row.owed = theirs[mix(column.bag)][mix(row.bag)]
        set column.owed = payoff[mix(column.bag)][mix(row.bag)]
      }
      set row.brought = row.bag  set row.faced = column.bag  set column.brought = column.bag  set column.faced = row.bag
      each agent as one in { row, column } { set one.frozen = freeze + 1  tally met for one }
    }
    each agent where agent.rivals is not nobody { set agent.rivals = nobody }
  }
  metrics { event collected by { bach, stravinsky }  event destroyed by { bach, stravinsky } }
  observe {
    show patch as { bach where patch.stock is ripe and patch.class is bach, stravinsky where patch.stock is ripe, floor }
    hide other.badge
    show agent.fan_of
    show other.fan_of
  }
  look patch where patch.stock is ripe and patch.class is bach       as sky gem
  look patch where patch.stock is ripe and patch.class is stravinsky as orange gem
  drop class
  checks music { require payoff[bach][bach] > theirs[bach][bach] and theirs[stravinsky][stravinsky] > payoff[stravinsky][stravinsky] }
  policy cooperator "gathers bach, and challenges whoever is nearest" {
    aim beam at agent as other where meets(agent, other, bach) choose interact
    seek patch where patch.class is bach and patch.stock is ripe avoiding patch where patch.class is stravinsky
  }
  policy defector "gathers stravinsky, and challenges whoever is nearest" {
    aim beam at agent as other where meets(agent, other, stravinsky) choose interact
    seek patch where patch.class is stravinsky and patch.stock is ripe avoiding patch where patch.class is bach
  }
}
