sj 1
game lb_foraging "Level-Based Foraging" {
  cite "Albrecht and Ramamoorthy 2013; Christianos et al. 2020; SocialJax, released code"
  about summary "Foragers and food have levels. Food is taken when the levels of the foragers beside it who load add up to its own;"
                "they share what it is worth by level. Who loads too little pays for it: most food needs company."
  about our_paradigm "stag hunt"   # ours: food of a high level pays those who come together, food of a low one can be had alone
  about our_long_term_impact "no"  # ours: what is taken is gone, and nothing else changes
  about our_multi_task "no"        # ours: taking food is the only task

  size  players   : count  = 4 in 2 .. 4   # released code
  size  foods     : count  = 4 in 1 .. 26  # released code: pieces of food
  size  richest   : count  = 3 in 1 .. 9   # released code: the highest level of food
  size  strongest : count  = 2 in 1 .. 9   # released code: the highest level of a forager
  param length    : steps  = 100           # released code
  param worth     : reward = 1             # released code: of each level of food
  param penalty   : reward = 0.1           # released code: for loading in vain
  episode length

  kind floor "." {
    field food : 0 .. richest = 0  # its level; 0: none
    blocks agents when floor.food > 0
  }
  kind start "P"
  kind wall  "#" { blocks agents }
  map "maps/lb_foraging.txt"

  agents players {
    acts stay, forward, backward, step_left, step_right, load
    moves compass
    field level : 1 .. strongest = 1
  }
  shape beside = diamond(1)  # released code: the four cells around

  phase start {
    each agent {
      send agent to start facing north
      draw level from 1 .. strongest
      set agent.level = level
    }
    pick foods floor {  # ours: all are placed; the released code loses one that it draws where it cannot lie
      draw level from 1 .. richest
      set floor.food = level
    }
  }

  schedule walk -> load -> finish

  phase walk { move each agent }
  phase load {
    each floor where floor.food > 0 {
      let strength = sum(agent.level over agent in beside of floor where agent chose load)
      when strength > 0 and strength >= floor.food {
        each agent in beside of floor where agent chose load {
          give worth * floor.food * agent.level / strength to agent
          tally shared for agent
        }
        tally taken
        set floor.food = 0
      } otherwise {
        each agent in beside of floor where agent chose load { give -penalty to agent  tally vain for agent }
      }
    }
  }
  phase finish { when count(floor where floor.food > 0) == 0 { end } }

  look agent where agent.level == 2 with yellow apple
  look agent where agent.level > 2  with red apple
  look floor where floor.food == 1  as green tree
  look floor where floor.food == 2  as green tree with yellow apple
  look floor where floor.food > 2   as green tree with red apple

  observe {
    window ahead 4, behind 4, left 4, right 4  # ours: as far to each side
    show floor.food as {
      one where floor.food == 1,
      two where floor.food == 2,
      three where floor.food == 3,
      four where floor.food == 4,
      five where floor.food == 5,
      six where floor.food == 6, seven where floor.food == 7, eight where floor.food == 8, nine where floor.food == 9, none
    }
    show agent.level  show other.level
  }
  metrics { event taken  event shared  event vain  mean left = count(floor where floor.food > 0) }
  checks {
    symmetric agents
    always count(floor where floor.food > 0) <= foods  # none grows
    always shared >= taken and vain >= 0
    require worth > 0 and penalty >= 0
    expect taken > 0 with random over 10 episodes
    expect taken == 0 and vain == 0 with never(load) over 10 episodes
  }
  define ready(place)   = sum(one.level over agent as one where distance(one, place) == 1)
  define journey(place) = sum(distance(one, place) over agent as one)
  define possible       = sum(one.level over agent as one)
  define far            = 1000  # ours: more steps than lie between any agents and a food
  define nearest        = min(journey(place) over floor as place where place.food > 0 and place.food <= possible otherwise far)
  policy cooperator "goes to the food that is nearest to all, and loads when those beside it are strong enough" {
    when count(floor as place in beside of agent where place.food > 0 and ready(place) >= place.food) > 0 choose load
    aim beside at floor where floor.food > 0 and journey(floor) == nearest choose stay
  }
  policy defector "takes what it can take alone" { aim beside at floor where floor.food > 0 and floor.food <= agent.level choose load }
  scenario visitors "two visitors among foragers who go alone" {
    slots (players - players % 2) / 2 focal  slots (players + players % 2) / 2 policy defector
  }
  scenario newcomer "a newcomer among foragers who meet" { slots 1 focal  slots players - 1 policy cooperator }
  scenario residents "residents meet one who goes alone" { slots players - 1 focal  slots 1 policy defector }
  variant socialjax "as released: the window of 8 x 8, one's own cell the fifth of both" {
    observe { window ahead 4, behind 3, left 4, right 3 }  # released code
    group board = floor, start, wall
    # released code: each of num_food tries draws any cell of the board, and is lost where that is no floor or has food already
    phase start {
      each agent {
        send agent to start facing north
        draw level from 1 .. strongest
        set agent.level = level
      }
      pick foods board as cell {
        draw level from 1 .. richest
        draw earlier from 1 .. 112  # ours: nearly as likely below `foods` as one before it drew the same of 56 cells
        each floor where floor.row == cell.row and floor.col == cell.col and earlier >= foods { set floor.food = level by lot }
      }
    }
  }
}
