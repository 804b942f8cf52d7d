sj 1
game open_harvest "Open Harvest" {
  cite "OpenSocialJax: its released code of `open_harvest`, and the settings of its harness for language models"
  about summary "Apples of five hues ripen, grow overripe and rot. What an apple pays at each stage, and how fast its cell bears"
                "again, are rules of its hue that nobody is told. They last for five trials, so that what is found out pays later."
  about our_differences "Not copied from OpenSocialJax: no reward in a trial's last step; rewards multiplied by the number of agents;"
                        "beam marks that block movement and growth for a step; a wrong neighbour at one edge of the map; bare trees that"
                        "aren't seen. It has 256 maps; this game has one, drawn by the same rules; `map=` takes others."
  about our_paradigm "commons"       # ours: a patch eaten bare bears nothing until the next trial
  about our_long_term_impact "high"  # ours
  about our_multi_task "yes"         # ours: to find out, to leave apples, to eat them at their best
  about our_difficulty "very hard"   # ours: what is learnt holds for one episode

  size  players     : count       = 5 in 1 .. 20                             # harness; ours: the map has 20 gates
  size  rounds      : count       = 5 in 1 .. 100                            # harness: trials of an episode
  param length      : steps       = 300  # harness: steps of a trial
  size  pace_least  : steps       = 15 in 1 .. 100                           # harness: an apple draws how long it stays at each stage
  size  pace_most   : steps       = 20 in 1 .. 100                           # harness
  param rot_least   : steps       = 2 in 1 .. 100  # harness: when an apple has rotted, another grows so long after
  param rot_most    : steps       = 5 in 1 .. 100                            # harness
  param regrow_1    : probability = 0.001 in 0 .. 0.25  # released code: one apple near; ours: at most 0.25, as speed can be 4
  param regrow_2    : probability = 0.005 in 0 .. 0.25                       # released code: two
  param regrow_3    : probability = 0.025 in 0 .. 0.25                       # released code: three or more
  param pause       : steps       = 2 in 0 .. 1000                           # released code: after a zap
  param freeze      : steps       = 12 in 0 .. 1000                          # harness; released code: 4
  param pay         : reward      = { best: 1, middling: 0.5, worst: 0.25 }  # released code
  param speed       : number      = { best: 2, middling: 1, worst: 0.5 } in 0 .. 4  # released code
  # an order names the stages from best to worst: `oru` is overripe, ripe, unripe
  param unripe_is   : word        = { uro: best, uor: best, ruo: middling, rou: worst, our: middling, oru: worst }
  param ripe_is     : word        = { uro: middling, uor: worst, ruo: best, rou: best, our: worst, oru: middling }
  param overripe_is : word        = { uro: worst, uor: middling, ruo: worst, rou: middling, our: best, oru: best }
  episode rounds trials of length { keep tree.hue }
  task rules {                           # released code: 36 pairs of orders for each hue
    field pay_order by { red, yellow, green, cyan, purple } : { uro, uor, ruo, rou, our, oru }
    field speed_order by { red, yellow, green, cyan, purple } : { uro, uor, ruo, rou, our, oru }
  }
  hold out late_red of rules where pay_order[red] in { our, oru }

  kind ground "."  kind gate "P"
  kind tree "1" {
    field patch : 1 .. 6 = 1
    field hue   : { red, yellow, green, cyan, purple } = red
    field fruit : { bare, unripe, ripe, overripe, rotted } = unripe
    field taken : { unripe, ripe, overripe } = unripe  # at what stage its last apple was eaten
    field pace  : pace_least .. pace_most = pace_least
    timer left
    glyph "2" with patch = 2  glyph "3" with patch = 3  glyph "4" with patch = 4  glyph "5" with patch = 5  glyph "6" with patch = 6
  }
  map "maps/open_harvest.txt"

  agents players {
    acts turn_left, turn_right, step_right, step_left, backward, forward, stay, zap  # released code
    moves compass
    timer hot  forbid zap when agent.hot > 0  timer frozen  forbid all when agent.frozen > 0
  }
  shape beam { ".x."  # released code: four cells
               "xxx"
               ".^." }
  define rank(order, stage) = case stage { unripe: unripe_is[order], ripe: ripe_is[order], overripe: overripe_is[order] }
  define has_apple(cell) = cell.fruit in { unripe, ripe, overripe }
  define dead = all (tree where tree.fruit is bare)  # nothing grows any more
  define near(cell) = count(tree as other in disc(2) of cell where has_apple(other))
  define regrowth(cell) = speed[rank(speed_order[cell.hue], cell.taken)] * case near(cell) { 0: 0, 1: regrow_1, 2: regrow_2, 3..: regrow_3 }

  phase start {
    each agent { send agent to gate }  draw hues by 1 .. 6 from { red, yellow, green, cyan, purple }
    each tree {
      set tree.hue = hues[tree.patch]
      draw pace from pace_least .. pace_most
      set tree.pace = pace  set tree.left = pace
    }
  }
  schedule tick -> grow -> walk -> eat -> fire

  phase grow {
    each tree where tree.fruit in { bare, rotted } and nobody on tree {
      chance case tree.fruit is rotted { yes: case tree.left == 0 { yes: 1, no: 0 }, no: regrowth(tree) } {
        draw pace from pace_least .. pace_most
        set tree.fruit = unripe  set tree.pace = pace  set tree.left = pace  tally grown
      }
    }
    each tree where tree.fruit is unripe and tree.left == 0 { set tree.fruit = ripe  set tree.left = tree.pace }
    each tree where tree.fruit is ripe and tree.left == 0 { set tree.fruit = overripe  set tree.left = tree.pace }
    each tree where tree.fruit is overripe and tree.left == 0 {
      draw wait from rot_least .. rot_most
      set tree.fruit = rotted  set tree.left = wait  tally rots
    }
  }
  phase walk { move each agent }
  phase eat {
    each agent on tree where has_apple(tree) {
      let value = rank(pay_order[tree.hue], tree.fruit)
      give pay[value] to agent  tally eaten[value] for agent
      set tree.taken = tree.fruit  set tree.fruit = bare
    }
  }
  phase fire {
    each agent as zapper where zapper chose zap {
      mark beam of zapper  set zapper.hot = pause
      each agent as victim in beam of zapper { send victim to gate  set victim.frozen = freeze  tally hits for zapper }
    }
  }
  look tree where tree.hue is red as "#b85548"  look tree where tree.hue is yellow as "#f3e77a"
  look tree where tree.hue is green as "#8fbf6a"  look tree where tree.hue is cyan as "#a9dfe3"
  look tree where tree.hue is purple as "#9d7cc4"  look tree where tree.fruit is unripe as green bush
  look tree where tree.fruit is ripe as red apple  look tree where tree.fruit is overripe as black apple
  look tree where tree.fruit is rotted as brown mushroom
  observe {
    window ahead 9, behind 1, left 5, right 5  # released code: 11 x 11
    show agent.heading                         # ours: compass moves need it
    show tree.fruit as { unripe where tree.fruit is unripe, ripe where tree.fruit is ripe, overripe where tree.fruit is overripe, bare }
    hide tree.taken
  }
  metrics {
    event eaten by { best, middling, worst }  event grown  event rots  event hits
    mean apples_left = count(tree where has_apple(tree))  mean alive = case dead { yes: 0, no: 1 }
  }
  checks {
    require pace_least <= pace_most and rot_least <= rot_most
    require regrow_1 <= regrow_2 and regrow_2 <= regrow_3
    require pay[best] > pay[middling] and pay[middling] > pay[worst]
    always count(agent on tree where has_apple(tree)) == 0
    always not before(dead) or dead or step == 0
    symmetric agents  expect hits == 0 with never(zap) over 5 episodes
  }
  # Points in an episode: greedy 193 (183 to 202), oracle 790 (726 to 855); OpenSocialJax's own: 169 to 204, and 541 to 673.
  define keep       = 3   # ours: apples near, for which regrow_3 holds
  define harvest    = 40  # ours: steps that are left when all is gathered in
  define good(cell) = has_apple(cell) and rank(pay_order[cell.hue], cell.fruit) is best
  policy greedy "eats the nearest apple" { seek tree where has_apple(tree) }
  policy oracle "knows the rules: eats apples at their best, where three others stand near, and all in the end" {
    seek tree where good(tree) and (near(tree) >= keep or step + harvest >= length) avoiding tree where has_apple(tree)
    seek tree where has_apple(tree) and step + harvest / 2 >= length
    seek ground avoiding tree where has_apple(tree)
  }
  scenario newcomer "a newcomer among those who know the rules" { slots 1 focal  slots players - 1 policy oracle }
  variant told "sees the hidden rules" { observe { show pay_order  show speed_order } }
  variant train_16 "learns from 16 tasks" { train on 16 of rules seed 0 }
  variant train_256 "learns from 256 tasks" { train on 256 of rules seed 0 }
}
