sj 1
game bridge "Planks are laid over a gap, and taken up again when nobody is on them" {
  episode 300
  kind shore "."
  kind pile  "P" { blocks agents }
  kind gap   "~" { field plank : { no, yes } = no  blocks agents when gap.plank is no }
  kind far   "f"
  map { "..~~ff"
        "P.~~ff"
        "..~~ff" }
  agents 3 {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, lay, fetch
    moves relative
    field plank : { no, yes } = no
  }
  shape hands = line(1)
  field cut : 0 .. 1000 capped = 0
  phase start { each agent { send agent to shore } }
  schedule walk -> stack -> take -> lay -> arrive
  phase walk { move each agent }
  phase stack {
    each agent where agent chose fetch and agent.plank is no { first pile in hands of agent { set agent.plank = yes  add 1 to cut } }
  }
  phase take {
    match agent as worker with first gap in hands of worker where worker chose fetch and worker.plank is no and gap.plank is yes
        and nobody on gap {
      set gap.plank = no  set worker.plank = yes
    }
  }
  phase lay {
    match agent as worker with first gap in hands of worker where worker chose lay and worker.plank is yes and gap.plank is no {
      set gap.plank = yes  set worker.plank = no
    }
  }
  phase arrive { each agent on far { give 1 to agent  tally crossed for agent } }
  metrics { event crossed }
  checks {
    always count(agent on gap where gap.plank is no) == 0
    always cut == count(gap where gap.plank is yes) + count(agent where agent.plank is yes)
  }
  variant fault "a plank can be taken away under another's feet" {
    phase take {
      match agent as worker with first gap in hands of worker where worker chose fetch and worker.plank is no and gap.plank is yes {
        set gap.plank = no  set worker.plank = yes
      }
    }
  }
}
