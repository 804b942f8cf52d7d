sj 1
game open_clean_up "Open Clean Up" {
  cite "OpenSocialJax: its released code of `open_cleanup`, variant crafted tools, and the settings of its harness for language models"
  about summary "Apples grow while the river is clean, and waste must be cleared with tools. A tool is made by picking up two things in"
                "the right order. Nobody is told the recipes, which last for five trials: they have to be found out together."
  about our_differences "Not copied from OpenSocialJax: no reward in a trial's last step; rewards multiplied by the number of agents;"
                        "a thing in each hand, when a trial begins, that makes no tool; beams that hit the cell in front where a side"
                        "cell is off the map; bare orchard and cells under agents that aren't seen. It has 256 maps, this game one;"
                        "`map=` takes others."
  about our_paradigm "commons"       # ours: whoever cleans works for all who eat
  about our_long_term_impact "high"  # ours
  about our_multi_task "yes"         # ours: to find recipes, to clean, to eat
  about our_difficulty "very hard"   # ours: random players clear next to nothing

  size  players      : count       = 5 in 2 .. 7    # harness; ours: the map has 7 gates
  size  rounds       : count       = 5 in 1 .. 100  # harness: trials
  param length       : steps       = 400            # harness: of a trial
  param apple        : reward      = 1              # released code
  param grace        : steps       = 50             # released code: the first new waste falls in step grace + 1
  param pollution    : probability = 0.1            # harness: that one clean cell is soiled, per step; released code: 0.5
  param initial_dirt : probability = 1              # harness: of each cell that begins dirty on the map
  param skew         : probability = 1              # harness: that waste has the hue of the episode; otherwise any hue
  param best_rate    : probability = 0.05           # released code: apple growth in a clean river, per orchard cell and step
  param spoiled_at   : fraction    = 0.4            # released code: dirt at which growth is zero
  param perfect_at   : fraction    = 0.0            # released code: dirt at which growth is best_rate
  size  things       : count       = 4 in 4 .. 4    # released code: flint, cord, reed and clay, of which two in order make a tool
  param number_of    : count       = { none: 16, flint: 0, cord: 1, reed: 2, clay: 3 }  # ours: with `none`, no pair is a recipe
  episode rounds trials of length
  task rules {
    # what makes light waste of a hue water, mid waste light, and dark waste mid
    field recipe by { red, yellow, green, cyan, purple, mid, dark } : different 0 .. things * things - 1
    field main_hue : { red, yellow, green, cyan, purple }
  }
  hold out dark_by_clay of rules where recipe[dark] in 12 .. 15

  kind grass   "."
  kind water   "H" {
    field state : { clean, light, mid, dark } = clean  glyph "F" with state = light
    field hue : { red, yellow, green, cyan, purple } = red
  }
  kind stream  "S"  # river that never gets dirty
  kind orchard "B" { field fruit : { none, ripe } = none }
  kind station "1" {
    field tool : { flint, cord, reed, clay } = flint
    glyph "2" with tool = cord  glyph "3" with tool = reed  glyph "4" with tool = clay
  }
  kind gate    "P"
  group river = water, stream
  map "maps/open_clean_up.txt"

  agents players {
    acts turn_left, turn_right, step_right, step_left, backward, forward, stay, zap, clean, pick_up  # released code
    moves compass
    field older : { none, flint, cord, reed, clay } = none  # what it picked up last but one
    field newer : { none, flint, cord, reed, clay } = none  # what it picked up last
  }
  shape beam { ".x."  # released code: four cells, for both beams
               "xxx"
               ".^." }
  define dirt    = count(water where water.state is not clean) / count(river)
  define growth  = best_rate * ramp(dirt, spoiled_at, perfect_at)  # 0 at spoiled_at, 1 at perfect_at, clipped
  define pair(a) = things * number_of[a.older] + number_of[a.newer]

  phase start {
    each agent { send agent to gate }
    each water where water.state is light {
      chance initial_dirt {
        draw shade from { light, mid, dark }
        set water.state = shade
        chance skew { set water.hue = main_hue } otherwise { draw hue from { red, yellow, green, cyan, purple }  set water.hue = hue }
      } otherwise { set water.state = clean }
    }
  }
  schedule grow -> pollute -> walk -> eat -> collect -> scrub -> fire

  phase grow {
    each orchard where orchard.fruit is none and nobody on orchard { chance growth { set orchard.fruit = ripe } }
  }
  phase pollute {
    when step > grace {
      chance pollution {
        pick 1 water where water.state is clean {
          when nobody on water {  # released code: if somebody stands there, none falls in this step
            draw shade from { light, mid, dark }
            set water.state = shade
            chance skew { set water.hue = main_hue } otherwise { draw hue from { red, yellow, green, cyan, purple }  set water.hue = hue }
          }
        }
      }
    }
  }
  phase walk { move each agent }
  phase eat {
    each agent on orchard where orchard.fruit is ripe { set orchard.fruit = none  give apple to agent  tally eaten for agent }
  }
  phase collect {
    each agent on station where agent chose pick_up { set agent.older = agent.newer  set agent.newer = station.tool  tally picks for agent }
  }
  phase scrub {
    each agent as cleaner where cleaner chose clean {
      mark beam of cleaner
      tally shots for cleaner
      each water in beam of cleaner where water.state is light and recipe[water.hue] == pair(cleaner) {
        set water.state = clean  tally cleared for cleaner
      }
      each water in beam of cleaner where water.state is mid and recipe[mid] == pair(cleaner) {
        set water.state = light  tally thinned for cleaner
      }
      each water in beam of cleaner where water.state is dark and recipe[dark] == pair(cleaner) {
        set water.state = mid  tally thinned for cleaner
      }
    }
  }
  phase fire {
    each agent as zapper where zapper chose zap {
      mark beam of zapper
      each agent as victim in beam of zapper { send victim to gate  tally hits for zapper }
    }
  }

  look water where water.state is clean                             as "#6fa8d6" water
  look water where water.state is not clean and water.hue is red    as "#8f2018" water
  look water where water.state is not clean and water.hue is yellow as "#f0dc60" water
  look water where water.state is not clean and water.hue is green  as "#6fae50" water
  look water where water.state is not clean and water.hue is cyan   as "#a0f0e8" water
  look water where water.state is not clean and water.hue is purple as "#5a2f80" water
  look water where water.state is mid                               with grey crate
  look water where water.state is dark                              with black crate
  look station where station.tool is flint                          as grey ore
  look station where station.tool is cord                           as orange flag
  look station where station.tool is reed                           as green banana
  look station where station.tool is clay                           as brown pot
  look stream                                                       as "#86b4d6" water

  observe {
    window ahead 9, behind 1, left 5, right 5  # released code: 11 x 11
    show agent.older  show agent.newer
    show agent.heading                         # ours: compass moves need it
    hide water.hue when water.state is clean
  }
  metrics {
    event eaten  event cleared  event thinned  event shots  event picks  event hits
    mean clean_water = count(water where water.state is clean)
  }
  checks {
    always dirt >= 0 and dirt <= 1
    monotone growth falling in dirt
    symmetric agents
    require perfect_at < spoiled_at
    always count(agent on orchard where orchard.fruit is ripe) == 0
    always not any (agent where agent.newer is none and agent.older is not none)
    expect cleared == 0 with never(clean), never(pick_up) over 5 episodes
    expect eaten == 0 with greedy over 5 episodes
    expect eaten > 0 with oracle over 2 episodes
  }
  policy greedy "eats the nearest apple, and never cleans" { seek orchard where orchard.fruit is ripe }
  # Apples in an episode: random 0, oracle 1416 (1217 to 1616). Agent 0 thins dark waste, agent 1 mid waste, the others clear what is light
  define aim_of(a) = case a.index == 0 { yes: recipe[dark], no: case a.index == 1 { yes: recipe[mid], no: recipe[main_hue] } }
  define next_of(a) = case number_of[a.newer] == quotient(aim_of(a), things) { yes: aim_of(a) % things, no: quotient(aim_of(a), things) }
  define its(a, cell) = a.index == 0 and cell.state is dark or a.index == 1 and cell.state is mid or a.index > 1 and cell.state is light
      and cell.hue is main_hue
  define clean_enough = 0.1  # ours
  policy oracle "knows the recipes: makes one tool, uses it while the river is dirty, and otherwise eats" {
    when pair(agent) != aim_of(agent) and any (station where distance(agent, station) == 0 and number_of[station.tool] == next_of(agent))
        choose pick_up
    seek station where pair(agent) != aim_of(agent) and number_of[station.tool] == next_of(agent)
    aim beam at water where its(agent, water) and dirt > clean_enough choose clean
    seek orchard where orchard.fruit is ripe
  }
  scenario newcomer "a newcomer among those who know the rules" { slots 1 focal  slots players - 1 policy oracle }
  scenario visitors "two among those who only eat" { slots 2 focal  slots players - 2 policy greedy }
  variant told "sees the hidden rules" { observe { show recipe  show main_hue } }
  variant train_16 "learns from 16 tasks" { train on 16 of rules seed 0 }
  variant train_256 "learns from 256 tasks" { train on 256 of rules seed 0 }
}
