sj 1
game crates "A crate is lifted by two at once and set down on the lorry by the same two at once" {
  episode 300
  kind yard  "."
  kind crate "C" { field here : { no, yes } = yes  field lifters : set of agent  blocks agents when crate.here is yes }
  kind lorry "L" { field unloaders : set of agent  blocks agents }
  map { ".....L"
        ".C...."
        "...C.L"
        "......" }
  agents 4 {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, lift, drop_off
    moves relative
    field load : { none, half } = none
  }
  shape arms = line(1)
  field lifted    : 0 .. 2000 capped = 0
  field delivered : 0 .. 2000 capped = 0
  phase start { each agent { send agent to yard } }
  schedule walk -> grip -> raise -> rest -> heave -> settle -> clear
  phase walk { move each agent }
  phase grip {
    each agent where agent chose lift and agent.load is none {
      first crate in arms of agent where crate.here is yes { add agent to crate.lifters }
    }
  }
  phase raise {
    each crate where count(agent in crate.lifters) >= 2 {
      set crate.here = no  add 1 to lifted
      pick 2 agent as one in crate.lifters { set one.load = half }
    }
  }
  phase rest { each crate { set crate.lifters = nobody } }
  phase heave {
    each agent where agent chose drop_off and agent.load is half { first lorry in arms of agent { add agent to lorry.unloaders } }
  }
  phase settle {
    each lorry where count(agent in lorry.unloaders) >= 2 {
      add 1 to delivered
      pick 2 agent as one in lorry.unloaders { set one.load = none  give 10 to one }
    }
  }
  phase clear { each lorry { set lorry.unloaders = nobody } }
  checks { always delivered <= lifted  always 2 * lifted == 2 * delivered + count(agent where agent.load is half) }
  variant fault "of three who lift one crate each carries a half" {
    phase raise {
      each crate where count(agent in crate.lifters) >= 2 {
        set crate.here = no  add 1 to lifted
        each agent as one in crate.lifters { set one.load = half }
      }
    }
  }
}
