sj 1
# Agents that are pushed, pulled, carried along and turned aside: one cell and several, alone and in rows.
game pushing "Pushes and pulls" {
  size reach : count = 3
  episode 60
  kind ice  "."
  kind rock "#" { blocks agents }
  kind door "d" { field state : { open, shut } = shut  blocks agents when door.state is shut  glyph "D" with state = open }
  kind belt ">" { field way : { north, east } = east  glyph "^" with way = north }
  map { ".>>d.."
        "^..#.D"
        "^....."
        "....d." }
  agents 6 {
    acts turn_left, turn_right, forward, stay, push, pull, jump, swap
    moves relative
    field force : 0 .. 3 = 1
    field hits  : 0 .. 9 capped = 0
  }
  phase start { each agent { send agent to ice } }
  schedule walk -> doors -> carry -> push -> pull -> jump -> swap -> shake -> strengthen -> scatter -> tick
  phase walk { move each agent }
  phase doors { each door { chance 0.3 { set door.state = case door.state { open: shut, shut: open } } } }
  phase carry { each agent on belt { send agent by 1 belt.way otherwise stay } }
  phase push {
    match agent as a with first agent as hit in line(2) of a where a chose push {
      send hit by a.force a.heading facing south otherwise stay
      add 1 to hit.hits
    }
  }
  phase pull {
    each agent as a where a chose pull {
      pick 1 agent as b where b is not a { send a by 1 toward b otherwise stay }
    }
    each agent as a where a chose stay {
      first ice in line(1) of a { send a by 2 away from ice facing north otherwise stay }
    }
  }
  phase jump {
    each agent where agent chose jump { send agent by min(agent.force + 1, reach) ahead otherwise stay }
    each agent where agent chose push { send agent by 1 back otherwise stay }
    each agent where agent chose pull { send agent by 1 left facing west otherwise stay }
    each agent as a where a chose forward { send a by 1 right otherwise stay }
  }
  phase swap {
    match agent as a with agent as b in line(1) of a where a chose swap {
      send a by 1 a.heading otherwise stay
      send b by 1 toward a facing east otherwise stay
    }
  }
  phase shake {
    match belt as b with agent as x in diamond(2) of b where x chose jump {
      each ice in disc(1) of b { send x by min(x.force, 2) x.heading otherwise stay }
    }
  }
  phase strengthen { each agent { draw more from 0 .. 3  set agent.force = more } }
  phase scatter {
    each agent where agent.hits > 2 {
      set agent.hits = 0
      chance 0.5 { send agent to belt otherwise stay } otherwise chance 0.5 { send agent to ice after 2 otherwise stay }
    }
    each agent where agent.hits == 1 { send agent by 1 east otherwise stay }
  }
  observe { window ahead 2, behind 1, left 1, right 1 }
  metrics { mean shut = count(door where door.state is shut) }
}
