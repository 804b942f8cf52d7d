sj 1
game territory "Territory: Rooms" {
  cite "Agapiou et al. 2022"
  about summary "Everybody begins in a room of precious bricks: who touches one or paints it owns it, and later it pays. A zap"
                "breaks walls for ever and throws players out: a plain partition can be kept, or fought over until nothing is left."
  about our_paradigm "commons"      # ours: a partition without force is best for all, a raid pays the raider
  about our_long_term_impact "yes"  # ours: what is broken never pays again
  about our_multi_task "yes"        # ours: claiming, guarding, raiding

  size players : count = 9 in 2 .. 9           # Melting Pot: one for each room
  size strikes : count = 2                     # Melting Pot: hits that break a brick, or throw a player out
  param length : steps = 1000  episode length  # Melting Pot: at least
  param yield  : reward      = 1               # Melting Pot
  param rate   : probability = 0.01            # Melting Pot: that a brick pays its owner, per step
  param drying : steps       = 25              # Melting Pot: from the claim until it may pay
  param mending : steps = 15  param mend : probability = 0.1  # Melting Pot: from the zap until it may mend; that it does
  param cooling  : steps = 4 in 0 .. 255       # Melting Pot: of one's own zap
  param frozen   : steps = 25 in 0 .. 255      # Melting Pot: after the first zap
  param recovery : steps = 50                  # Melting Pot: a second zap within them throws out for ever

  kind floor "."
  kind post  "#" { blocks agents, zap, paint }
  kind brick "R" {
    field paint  : { none, wet, dry } = none          # only a dry one pays
    field damage : 0 .. strikes capped = 0
    field owner : agent  field rivals : set of agent  # rivals: all who claim it in this step
    timer wetness  timer dust
    blocks agents, zap when brick.damage < strikes    # Melting Pot: paint goes through
  }
  kind gate  "P"
  map "maps/territory.txt"

  agents players {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, zap, paint
    moves relative
    field hits : 0 .. strikes capped = 0  timer recovering
    timer stunned  forbid all when agent.stunned > 0  timer hot  forbid zap when agent.hot > 0
  }
  shape touch = line(1)  shape paint = line(2)  shape zap = fan(2, 1)  # Melting Pot: the brush in one's hand, its beam, the zap

  phase start { each agent { send agent to gate } }

  schedule tick -> age -> walk -> claim -> settle -> fire -> fall -> pay

  phase age {
    each brick where brick.paint is wet and brick.wetness == 0 { set brick.paint = dry }
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
    each brick as b where b.owner is not nobody and (b.damage == strikes or b.owner.hits == strikes) {
      set b.owner = nobody  set b.paint = none
    }
  }
  phase pay {
    each brick as b where b.paint is dry and b.owner is not nobody { chance rate { give yield to b.owner  tally paid for b.owner } }
  }

  look brick                               as "#b98d74" wall
  look brick where brick.damage > 0        as "#dcc6b8" wall
  look brick where brick.damage == strikes as "#e6e0da"
  look brick where brick.damage == strikes as grey floor
  look brick where brick.paint is wet      with white
  look brick where brick.paint is dry      with yellow coin

  observe {
    window ahead 9, behind 1, left 5, right 5  show agent.stunned  show agent.hot  show other.hits  # Melting Pot: the window
    show brick.owner as { mine where brick.owner is agent, free where brick.owner is nobody, theirs }
    show brick.damage as { whole where brick.damage == 0, cracked where brick.damage < strikes, gone }
  }
  metrics { event claimed  event paid  event blows  event gone  mean owned = count(brick where brick.owner is not nobody) }
  checks {
    symmetric agents
    always count(brick where brick.owner is nobody and brick.paint is not none) == 0
    always count(brick where brick.damage == strikes and brick.owner is not nobody) == 0
    expect paid > 0 with random over 10 episodes
    expect blows == 0 and gone == 0 with never(zap) over 10 episodes
  }
  variant socialjax
      "as released: compass moves, another map, pay after 100 quiet steps; who is zapped begins anew, owners lose struck bricks" {
    cite "Agapiou et al. 2022; SocialJax, released code"
    map "maps/territory_socialjax.txt"  # released code
    set yield = 0.01                    # released code: of each brick, in every step
    size peace : count = 100            # released code: steps without a change by paint or zap, until a brick pays its owner
    drop drying  drop mending  drop mend  drop cooling  drop frozen  drop recovery  drop rate  drop age  drop recovering
    kind brick "R" {
      field paint  : { none, wet, dry } = none  # only a dry one pays
      field damage : 0 .. strikes capped = 0
      field quiet  : 0 .. peace capped = 0      # steps in peace, owned or not
      field owner : agent  field rivals : set of agent
      blocks agents when brick.damage < strikes
    }
    kind post  "#" { blocks agents }
    agents { moves compass }
    observe { show agent.heading }     # ours: compass moves need it; the released view reveals half of it
    shape zap { ".x."  "xxx"  ".^." }  # released code: walls do not stop it
    schedule tick -> walk -> claim -> settle -> brush -> spread -> fire -> fall -> pay
    phase claim { each agent as a { each brick in touch of a where nobody on brick { add a to brick.rivals } } }
    phase settle {                     # released code: a touch mends a brick, and leaves it its peace
      each brick where brick.rivals is not nobody {
        pick 1 agent as winner in brick.rivals {
          when winner is not brick.owner { tally claimed for winner }
          set brick.owner = winner
        }
        when brick.paint is none { set brick.paint = wet }
        set brick.damage = 0  set brick.rivals = nobody
      }
    }
    phase brush {
      each agent as a where a chose paint { each brick in paint of a where brick.damage == 0 { add a to brick.rivals } }
    }
    phase spread {
      each brick where brick.rivals is nobody { add 1 to brick.quiet }
      each brick where brick.rivals is not nobody {
        pick 1 agent as winner in brick.rivals {
          when winner is brick.owner { set brick.quiet = min(brick.quiet + 1, peace) }
          otherwise { set brick.owner = winner  set brick.paint = wet  set brick.quiet = 0  tally claimed for winner }
        }
        set brick.rivals = nobody
      }
    }
    phase fire {  # released code: a zap breaks what is owned, and then what is cracked
      each agent as zapper where zapper chose zap {
        mark zap of zapper
        each agent as victim in zap of zapper { add 1 to victim.hits }
        each brick in paint of zapper where brick.damage < strikes and (brick.damage > 0 or brick.owner is not nobody) {
          set brick.damage = min(brick.damage + 1, strikes)  set brick.owner = nobody  set brick.paint = none  set brick.quiet = 0
          tally blows for zapper
        }
      }
    }
    phase fall {
      each agent as a where a.hits > 0 { send a to gate  set a.hits = 0  tally gone for a }
      each brick where brick.quiet == peace and brick.owner is not nobody { set brick.paint = dry }
    }
    phase pay { each brick as b where b.paint is dry and b.owner is not nobody { give yield to b.owner  tally paid for b.owner } }
    observe {
      hide other.hits  hide agent.stunned  hide agent.hot  hide content on agents
      show post as { outside }  show gate as { floor }
      hide brick.paint  hide brick.damage
      show brick.owner as { free where brick.owner is nobody and brick.damage == 0, held }  # released code: owned or struck ones look bare
    }
  }
}
