sj 1
game territory_open "Territory" extends "shared/endings.sj" {
  cite "Agapiou et al. 2022; territory of Melting Pot 2"
  about summary "Bricks are walls and riches at once: who touches one or paints it owns it, and later it pays. Two zaps break a brick"
                "for ever, and throw a player out for ever. Borders can be agreed on, or fought over."
  about our_paradigm "commons"  # ours: a partition without force is best for all, a raid pays the raider

  size players : count = 9 in 2 .. 9             # Melting Pot
  size strikes : count = 2                       # Melting Pot: hits that break a brick, or throw a player out
  param longest : steps = 5000  episode longest  # Melting Pot
  # Melting Pot: from then on the episode may end, each so many steps, with this probability
  param soonest : steps = 1000  param interval : steps = 100 in 1 .. 5000  param ending : probability = 0.2
  param yield : reward = 1  param rate : probability = 0.01                  # Melting Pot: that a brick pays its owner, per step
  param drying : steps = 26                      # Melting Pot: from the claim until it may pay
  param mending : steps = 16  param mend : probability = 0.1                 # Melting Pot: from the zap until it may mend; that it does
  param cooling  : steps = 4 in 0 .. 100         # Melting Pot: of one's own zap
  param frozen   : steps = 24 in 1 .. 100        # Melting Pot: 25 after the first zap, with its own step
  param recovery : steps = 49                    # Melting Pot: a second zap within them throws out for ever
  param likely : probability = 0.66667  param unlikely : probability = 0.25  # Melting Pot: odds of 2 to 1 and of 1 to 3, in Inside Out

  kind floor "."  kind gate "P"
  kind post  "#" { blocks agents, zap, paint }
  kind brick "R" {
    field sort : { sure, likely_one, unlikely_one } = sure  glyph "A" with sort = likely_one  glyph "B" with sort = unlikely_one
    field paint  : { none, wet, dry } = none          # Melting Pot: it looks dry from its first payment on
    field damage : 0 .. strikes capped = 0
    field owner : agent  field rivals : set of agent  # rivals: all who claim it in this step
    timer wetness  timer dust
    blocks agents when brick.damage < strikes  blocks zap when brick.damage + 1 < strikes  # Melting Pot: zaps go on through what they break
  }
  map "maps/territory_open.txt"  # Melting Pot

  agents players {
    acts stay, forward, backward, step_left, step_right, turn_left, turn_right, zap, paint  # Melting Pot: in this order
    moves relative  blocks zap
    field badge : 0 .. players = 0  # others see it: players have colours of their own
    field hits : 0 .. strikes capped = 0  timer recovering  timer stunned  timer hot
    forbid zap when agent.hot > 0   # Melting Pot: who is stunned can still paint
    forbid forward, backward, step_left, step_right, turn_left, turn_right when agent.stunned > 0
  }
  shape touch = line(1)  shape paint = line(2)  shape zap = fan(2, 1)  # Melting Pot: the brush in one's hand, its beam, the zap
  define owned_by(b, number) = b.owner is not nobody and b.owner.badge == number
  phase start {
    each agent { send agent to gate  set agent.badge = agent.index + 1 }
    each brick where brick.sort is likely_one { chance 1 - likely { set brick.damage = strikes } }
    each brick where brick.sort is unlikely_one { chance 1 - unlikely { set brick.damage = strikes } }
  }

  schedule tick -> age -> walk -> claim -> settle -> fire -> fall -> pay -> close
  phase age {
    each brick where brick.damage > 0 and brick.damage < strikes and brick.dust == 0 { chance mend { add -1 to brick.damage } }
  }
  phase walk { move each agent }
  phase claim {  # all claims of a step are collected first ...
    each agent as a { each brick in touch of a { add a to brick.rivals } }
    each agent as a where a chose paint { mark paint of a  each brick in paint of a { add a to brick.rivals } }
  }
  phase settle {  # ... and one of them holds
    each brick where brick.rivals is not nobody {
      pick 1 agent as winner in brick.rivals {
        when winner is not brick.owner and brick.damage < strikes {
          set brick.owner = winner  set brick.paint = wet  set brick.wetness = drying  tally claimed for winner
        }
      }
      set brick.rivals = nobody
    }
  }
  phase fire {
    each agent as zapper where zapper chose zap {
      mark zap of zapper  set zapper.hot = cooling
      first agent as victim in zap of zapper { add 1 to victim.hits  set victim.stunned = frozen  set victim.recovering = recovery }
      each brick in zap of zapper where brick.damage < strikes { add 1 to brick.damage  set brick.dust = mending  tally blows for zapper }
    }
  }
  phase fall {
    each agent as a { when a.hits == strikes { remove a  tally gone for a } otherwise when a.recovering == 0 { set a.hits = 0 } }
    each agent where agent.stunned == frozen { set agent.hot = frozen + cooling + 1 }  # Melting Pot: the zapper cools when all is over
    each brick as b where b.owner is not nobody and (b.damage == strikes or b.owner.hits == strikes) {
      set b.owner = nobody  set b.paint = none
    }
  }
  phase pay {
    each brick as b where b.owner is not nobody and b.wetness == 0 {
      chance rate { give yield to b.owner  set b.paint = dry  tally paid for b.owner }
    }
  }
  phase close { when may_end(soonest, interval) { chance ending { end } } }
  look brick                               as "#b98d74" wall
  look brick where brick.damage > 0        as "#dcc6b8" wall
  look brick where brick.damage == strikes as "#e6e0da"
  look brick where brick.damage == strikes as grey floor
  look brick where brick.paint is wet      with white
  look brick where brick.paint is dry      with yellow coin
  observe {
    window ahead 9, behind 1, left 5, right 5  # Melting Pot
    show agent.badge  show other.badge  show other.hits  show agent.hits  show agent.hot  show gate as { floor }  hide brick.sort
    show brick.owner as {
      free where brick.owner is nobody, of_1 where owned_by(brick, 1), of_2 where owned_by(brick, 2),
      of_3 where owned_by(brick, 3), of_4 where owned_by(brick, 4), of_5 where owned_by(brick, 5),
      of_6 where owned_by(brick, 6), of_7 where owned_by(brick, 7), of_8 where owned_by(brick, 8), of_9 }
    show brick.damage as { whole where brick.damage == 0, cracked where brick.damage < strikes, gone }
  }
  metrics { event claimed  event paid  event blows  event gone  mean owned = count(brick where brick.owner is not nobody) }
  checks {
    always count(brick where brick.owner is nobody and brick.paint is not none) == 0
    always count(brick where brick.damage == strikes and brick.owner is not nobody) == 0
    symmetric agents  expect blows == 0 and gone == 0 with never(zap) over 10 episodes
  }
  variant rooms "Everybody begins in a room of bricks" { map wraps "maps/territory_rooms.txt" }  # Melting Pot
  variant inside_out "Five players around a maze of bricks that differs from episode to episode" {
    set players = 5  map "maps/territory_inside_out.txt"  # Melting Pot
    param beside : probability = 0.22222  # Melting Pot: 16 of the places are there in one of 7 cases, beside 8 that always are
    kind porch "Q"
    observe { show porch as { floor } }
    phase start {
      each agent { set agent.badge = agent.index + 1  chance beside { send agent to porch } otherwise { send agent to gate } }
      each brick where brick.sort is likely_one { chance 1 - likely { set brick.damage = strikes } }
      each brick where brick.sort is unlikely_one { chance 1 - unlikely { set brick.damage = strikes } }
    }
  }
}
