sj 1
game pond {
  param many : count = 3
  episode 20
  kind shore "." { field fruit : { none, ripe } = none  field crop : 0 .. 5 capped = 0  field owner : agent }
  kind water "~"
  map { "...~"
        "...~" }
  agents 2 {
    acts turn_left, turn_right, forward, stay
    moves relative
    field bag : 0 .. 3 capped = 0
  }
  phase start { each agent { send agent to shore } }
  schedule grow -> walk
  phase grow {
    each shore where nobody on shore { chance 0.1 { set shore.fruit = ripe  add many to shore.crop } }
    each agent on shore { set shore.owner = agent }
  }
  phase walk { move each agent  }
  observe { window ahead 2, behind 1, left 1, right 1  show agent.bag }
  look shore where step > 10 as brown
  look shore where shore.crop > many as green
  look shore where shore.owner is not nobody and shore.owner.bag > 2 as yellow
  look agent where agent.index == 0 as red
  look water where nobody on water as black
}
