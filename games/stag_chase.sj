sj 1
game stag_chase "Stags that Move" {
  cite "Peysakhovich and Lerer 2018, whose hunters chase a stag over a grid"
  about summary "Hunters chase stags, which smell them and flee, and hares, which anybody catches alone. A stag falls only to two who"
                "strike in the same step; who strikes it alone is kicked, and it bolts."
  about our_paradigm "stag hunt"   # ours: a stag pays most and takes two, a hare pays a little and takes one
  about our_long_term_impact "no"  # ours: what is caught comes back elsewhere
  about our_multi_task "no"        # ours: hunting is the only task

  size  players : count  = 4 in 2 .. 8      # ours: two for each stag
  size  herd    : count  = 2 in 1 .. 6      # ours: stags
  size  hares   : count  = 4 in 1 .. 9      # ours: one for each hunter
  size  scent   : cells  = 2 in 0 .. 9      # ours: from so near a stag smells a hunter
  param length  : steps  = 200              # ours: some forty chases
  param venison : reward = 5 in 0 .. 100    # ours: to each hunter who struck
  param game_   : reward = 1 in 0 .. 100    # ours: of a hare
  param kick    : reward = -0.5 in -9 .. 0  # ours: of a stag that is struck by one
  param bolting : steps  = 3 in 1 .. 20     # ours: so long it runs straight on
  param rebirth : steps  = 8 in 1 .. 99     # ours: until another comes in place of what was caught
  episode length

  kind meadow  "." { field clover : { none, grown } = none  glyph "," with clover = grown }
  kind thicket "t" { blocks stag }  # antlers
  kind wall    "#" { blocks agents, stag, hare }
  map "maps/stag_chase.txt"

  agents players {
    acts forward, backward, step_left, step_right, stay, strike
    moves compass
  }
  movers stag herd "S" {
    timer bolts
    field wind : { fresh, tired } = fresh  # one that has run rests in the next step
  }
  movers hare hares "h"
  define near(a, b) = distance(a, b) <= 1
  define smells(s)  = any (agent as a where distance(a, s) <= scent)

  phase start {
    each agent { send agent to meadow facing north }
    each stag { send stag to meadow facing north }  each hare { send hare to meadow facing north }
  }

  schedule tick -> walk -> hunt -> stagger -> bolt -> flee -> graze -> tire -> hop

  phase walk { move each agent }
  phase hunt {
    each stag {
      let hunters = count(agent as a where near(a, stag) and a chose strike)
      when hunters >= 2 {  # ours: the fewest that are not one
        each agent as a where near(a, stag) and a chose strike { give venison to a  tally hunted for a }
        tally felled
        send stag to meadow after rebirth
      } otherwise when hunters == 1 {
        each agent as a where near(a, stag) and a chose strike { give kick to a  tally kicked for a }
        set stag.bolts = bolting
      }
    }
    each hare {
      pick 1 agent as a where near(a, hare) and a chose strike and not any (stag where near(a, stag)) {
        give game_ to a  tally caught for a  send hare to meadow after rebirth
      }
    }
  }
  phase stagger {  # who was kicked
    each agent as a where a chose strike {
      pick 1 stag where near(a, stag) and stag.bolts == bolting { send a by 1 away from stag facing same otherwise stay }
    }
  }
  phase bolt { move each stag where stag.bolts > 0 ahead }
  phase flee {
    move each stag where stag.bolts == 0 and stag.wind is fresh and smells(stag) away from agent as a where distance(a, stag) <= scent
        avoiding thicket
  }
  phase graze {
    move each stag where stag.bolts == 0 and stag.wind is fresh and not smells(stag) toward meadow where meadow.clover is grown
        avoiding thicket
  }
  phase tire { each stag { set stag.wind = case stag.wind { fresh: tired, tired: fresh } } }
  phase hop { move each hare at random avoiding thicket }

  look meadow where meadow.clover is grown as green tree
  look stag                                as brown animal
  look hare                                as white animal

  observe {
    window ahead 4, behind 4, left 4, right 4  # ours: farther than a stag smells
    show stag.bolts as { bolting where stag.bolts > 0, calm }
  }
  metrics { event felled  event hunted  event caught  event kicked }
  checks {
    symmetric agents
    always all (stag where before(stag.bolts) - stag.bolts <= 1 or stag.bolts > 0)  # who bolts, bolts to the end
    require venison > game_ and game_ > 0  # a stag hunt: two do better with a stag
    expect felled == 0 and caught == 0 with never(strike) over 5 episodes
    expect felled > 0 with cooperator over 5 episodes
    expect felled < caught with defector over 5 episodes
  }
  policy cooperator "follows the nearest stag, and strikes when another hunter is beside it, too" {
    when any (stag where near(agent, stag) and any (agent as b where b is not agent and near(b, stag))) choose strike
    seek stag avoiding hare
  }
  policy defector "follows the nearest hare, and strikes" {
    when any (hare where near(agent, hare)) and not any (stag where near(agent, stag)) choose strike
    seek hare
  }
  scenario newcomer "a newcomer among hunters of stags" { slots 1 focal  slots players - 1 policy cooperator }
  scenario residents "residents meet one who hunts hares" { slots players - 1 focal  slots 1 policy defector }
}
