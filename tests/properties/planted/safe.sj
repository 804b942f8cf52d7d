sj 1
game safe "A safe opens once if the red and the blue lock are turned in one step, each with its own key" {
  episode 300
  kind floor "."
  kind wall  "#" { blocks agents }
  kind peg   "k" { field key : { none, red, blue } = none  glyph "r" with key = red  glyph "b" with key = blue }
  kind lock  "L" { field colour : { red, blue } = red  field turned : { no, yes } = no  glyph "M" with colour = blue  blocks agents }
  map { "r....b"
        "......"
        "#L##M#" }
  agents 3 {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, turn
    moves relative
    field key : { none, red, blue } = none
  }
  shape hand = line(1)
  field safe : { shut, ajar, empty } = shut
  field paid : 0 .. 300 capped = 0
  phase start { each agent { send agent to floor } }
  schedule walk -> grab -> work -> open -> pay -> release
  phase walk { move each agent }
  phase grab { each agent on peg where agent.key is none and peg.key is not none { set agent.key = peg.key  set peg.key = none } }
  phase work { each agent where agent chose turn { first lock in hand of agent where lock.colour is agent.key { set lock.turned = yes } } }
  phase open {
    when safe is shut and count(lock where lock.turned is yes and lock.colour is red) > 0 and count(lock where lock.turned is yes
        and lock.colour is blue) > 0 {
      set safe = ajar
    }
  }
  phase pay { when safe is ajar { set safe = empty  add 1 to paid  give 50 to all  tally opened } }
  phase release { each lock { set lock.turned = no } }
  metrics { event opened }
  checks { always paid <= 1 }
  variant fault "the safe that is empty opens again" {
    phase open {
      when count(lock where lock.turned is yes and lock.colour is red) > 0 and count(lock where lock.turned is yes
          and lock.colour is blue) > 0 {
        set safe = ajar
      }
    }
  }
}
