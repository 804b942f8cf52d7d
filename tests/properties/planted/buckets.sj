sj 1
game buckets "Water goes from hand to hand, from the well to the fire" {
  episode 200
  kind path "."
  kind well "W" { blocks agents }
  kind fire "F" { blocks agents }
  map { "W.....F"
        "......."
        "W.....F" }
  agents 4 {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, draw_water, pass_on, pour
    moves relative
    field full : { no, yes } = no
  }
  shape arm = line(1)
  field drawn  : 0 .. 2000 capped = 0
  field poured : 0 .. 2000 capped = 0
  phase start { each agent { send agent to path } }
  schedule walk -> fetch -> hand -> quench
  phase walk { move each agent }
  phase fetch {
    each agent where agent chose draw_water and agent.full is no { first well in arm of agent { set agent.full = yes  add 1 to drawn } }
  }
  phase hand {
    match agent as giver with first agent as taker in arm of giver where giver chose pass_on and giver.full is yes and taker.full is no {
      set giver.full = no  set taker.full = yes  tally passed for giver
    }
  }
  phase quench {
    each agent where agent chose pour and agent.full is yes {
      first fire in arm of agent { set agent.full = no  add 1 to poured  give 1 to all }
    }
  }
  metrics { event passed }
  checks { always drawn == poured + count(agent where agent.full is yes) }
  variant fault "a bucket handed to one whose bucket is full is spilt" {
    phase hand {
      match agent as giver with first agent as taker in arm of giver where giver chose pass_on and giver.full is yes {
        set giver.full = no  set taker.full = yes  tally passed for giver
      }
    }
  }
}
