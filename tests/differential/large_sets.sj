sj 1
game large_sets "Sets of more agents than one number of 32 bits holds" {
  size  players : count  = 40 in 2 .. 64
  param tip     : reward = 0.5
  episode 30
  kind grass "." { field visitors : set of agent  field seen_by by { low, high } : set of agent }
  kind rock  "o" { field visitors : set of agent }
  kind wall  "#" { blocks agents }
  group place = grass, rock
  map { "..o....o.."
        ".#....#..."
        "o....o...."
        "...#....o."
        "..o......."
        ".......#.."
        "o..o...o.." }
  field club  : set of agent
  field teams by { low, high } : set of agent
  field heads by agent : set of agent
  field king  : agent
  agents players {
    acts turn_left, turn_right, forward, stay, shake, drop_all
    moves relative
    field friends : set of agent
    field known   by { low, high } : set of agent
    field past    by 0 .. 2 : set of agent
    field met     by agent : set of agent
    field bag     : 0 .. 9 capped = 0
  }
  phase start { each agent { send agent to place } }
  schedule walk -> visit -> greet -> count_them -> choose -> leave -> lots
  phase walk { move each agent }
  phase visit {
    each agent on place { add agent to place.visitors }
    each agent on grass where agent.index >= 30 { add agent to grass.seen_by[high] }
    each agent on grass where agent.index < 35 { add agent to grass.seen_by[low] }
  }
  phase greet {
    each agent as a where a chose shake {
      each agent as b in disc(1) of a {
        add b to a.friends
        add b to a.known[case b.bag > 0 { yes: high, no: low }]
        add a to b.met[a]
        add b to heads[a]
      }
      add a to club
      add a to teams[case a.index > 31 { yes: high, no: low }]
      set a.past = shift(a.past, 1, a.friends)
    }
  }
  phase count_them {
    each agent as a {
      add min(1, count(agent as b in a.friends)) to a.bag
      when a in a.friends and a.friends is not nobody { give tip to a.friends  tally liked for a.friends }
      when king is not nobody and king in a.known[high] { tally knows_king }
      when king is not nobody and a in a.met[king] { tally met_king }
      when king is not nobody and a.past[a.bag % 3] is not nobody { give 0.25 to a.past[a.bag % 3] }
      when king in a.friends { tally friend_of_king }
    }
    each grass { when count(agent in grass.seen_by[high]) > count(agent in grass.seen_by[low]) { tally higher } }
    each rock where rock.visitors is nobody { tally lonely }
  }
  phase choose {
    pick 1 agent as one in club { set king = one } otherwise { set king = nobody }
    each rock { pick 1 agent as one in rock.visitors { give 1 to one } }
    each rock { pick 3 agent as one in rock.visitors where one.bag > 1 { give 2 to one } }
    each agent as a { pick 1 agent as one in a.friends { add 1 to one.bag } }
    give 0.125 to club
    give -0.5 to teams[high]
  }
  phase leave {
    each agent as a where a chose drop_all {
      set a.friends = nobody
      set a.known[high] = a.known[low]
      set a.met = nobody
    }
    each agent as a where a chose turn_left and a.bag > 2 { set a.known = a.friends }
    when 2 * count(agent in club) > players { set club = teams[low]  set teams = nobody }
    when king is not nobody { set heads[king] = club }
  }
  phase lots {
    each agent as a where a chose shake { each agent as b in line(1) of a { set b.friends = a.friends by lot } }
    each agent as a where a chose stay and a.bag > 4 { set club = a.friends by lot }
  }
  observe {
    window ahead 1, behind 1, left 1, right 1
    show agent.friends as { myself where agent in agent.friends, somebody where agent.friends is not nobody, no_one }
    show other.friends as { mine where agent in other.friends, not_mine }
    show grass as { visited where grass.visitors is not nobody, empty }
    show club as { member where agent in club, crowded where count(agent as one in club) > 20, outsider }
  }
  metrics {
    event liked  event knows_king  event met_king  event friend_of_king  event higher  event lonely
    mean members = count(agent in club)
  }
}
