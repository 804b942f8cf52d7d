sj 1
game sets "Sets, rows, owners, pairs" {
  size  players : count       = 6 in 2 .. 12
  size  cap     : count       = 4
  param price   : reward      = { wood: 1, stone: 2.5, gold: -1 }
  param yields  : count       = { wood: 2, stone: 1, gold: 0 } in 0 .. 3
  param next    : word        = { wood: stone, stone: gold, gold: gold }
  param payoff  : reward      = {
    wood: { wood: 1, stone: 0, gold: 2 }, stone: { wood: 3, stone: -1, gold: 0 }, gold: { wood: 0.5, stone: 0, gold: 4 } }
  param rare    : probability = 0.2 in 0 .. 0.5
  episode 60
  kind lawn "." { field owner : agent = nobody  field visitors : set of agent  field gift : reward = 0 }
  kind rock "R" { field kind_of : { wood, stone, gold } = wood  field hits : set of agent  timer closing }
  kind base "B"
  map { "BB.R..R."
        ".R....BB"
        "...RR..."
        "B..R...B" }
  field stock by { wood, stone, gold } : 0 .. 12 capped = 0
  field king  : agent = nobody
  field total : reward = 0
  agents players {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, hit, trade
    moves compass
    field bag     by { wood, stone, gold } : 0 .. cap capped = 0
    field friends : set of agent
    field partner : agent = nobody
    timer tired
    forbid hit, trade when agent.tired > 0
    forbid forward when stock[gold] > 2
  }
  shape ray = line(3)
  define rich(who) = sum(who.bag) > 0
  phase start { each agent { send agent to base } }
  schedule tick -> walk -> claim -> hit -> settle -> draws -> meet -> use(wood) -> use(gold) -> pay
  phase walk { move each agent }
  phase claim {
    each agent on lawn { set lawn.owner = agent  add agent to lawn.visitors  add 0.5 to lawn.gift }
    pick 1 agent where agent.moved { set king = agent } otherwise { set king = nobody }
  }
  phase hit {
    each agent as hitter where hitter chose hit {
      mark ray of hitter
      first rock in ray of hitter { add hitter to rock.hits }
      each agent as near in diamond(2) of hitter { add near to hitter.friends }
    }
  }
  phase settle {
    each rock where rock.hits is not nobody {
      let n = count(agent in rock.hits)
      when n >= 2 and rock.closing == 0 {
        give price[rock.kind_of] to rock.hits
        tally mined[rock.kind_of] by n for rock.hits
        set rock.closing = 3
        set rock.kind_of = next[rock.kind_of]
      } otherwise when rock.closing == 0 {
        pick 1 agent as lucky in rock.hits { add yields[rock.kind_of] to lucky.bag[rock.kind_of] }
      }
      set rock.hits = nobody
    }
    when king is not nobody { give 0.125 to king }
  }
  phase draws {
    each agent where agent.tired == 0 {
      draw roll from 1 .. 6
      draw side from { wood, gold }
      draw luck from { wood: rare, stone: 0.3, gold: 1 - rare - 0.3 }
      when roll > 4 { add 1 to agent.bag[side] }
      when luck is stone { add -1 to agent.bag[side]  tally lost for agent }
      when luck is side { give 0.1 * roll to agent }
    }
    pick 2 lawn where lawn.owner is not nobody { add 1 to stock[stone]  when lawn.owner is not nobody { give 0.01 to lawn.owner } }
  }
  phase meet {
    match agent as row with first agent as column in ray of row where row chose trade and rich(row) and rich(column) {
      give payoff[mix(row.bag)][mix(column.bag)] to row
      give payoff[highest(row.bag)][lowest(column.bag)] to column
      set row.partner = column
      set column.partner = row
      each agent as one in { row, column } { draw rest from 1 .. 4  set one.tired = rest  set one.bag = 0  tally met for one }
    }
  }
  phase use(what) {
    when stock[what] >= 0 { pick stock[stone] rock where rock.kind_of is what { set rock.kind_of = stone } }
    add 1 to stock[what]
    each agent where agent.bag[what] > 1 { set agent.bag[what] = 1 }
  }
  phase pay {
    when stock[gold] > 8 { set stock = 0  end }
    each lawn where lawn.owner is not nobody and lawn.gift > 2 {
      give lawn.gift to lawn.owner  set lawn.gift = 0  set lawn.visitors = nobody
    }
    each agent where agent in agent.friends or agent.partner is king { tally odd for agent  set agent.friends = nobody }
    set total = sum(lawn.gift over lawn)
  }
  observe {
    window ahead 3, behind 3, left 3, right 3
    show lawn.owner as { mine where lawn.owner is agent, theirs where lawn.owner is not nobody, free }
    hide rock.kind_of when rock.closing > 1
    show agent.tired  show agent.bag  show stock
    show other.partner as { me where other.partner is agent, none }
  }
  metrics { event mined by { wood, stone, gold }  event lost  event met  event odd  mean money = total }
}
