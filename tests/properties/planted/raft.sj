sj 1
game raft "A raft crosses the river when one of those aboard pulls the rope" {
  episode 200
  kind bank  "."
  kind river "~" { blocks agents }
  kind pier  "n" { blocks agents when side is away }
  kind quay  "f" { blocks agents when side is home }
  map { "....~~...."
        "...nn~ff.."
        "...nn~ff.."
        "....~~...." }
  field side : { home, away } = home
  agents 3 {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, pull
    moves relative
  }
  phase start { each agent { send agent to bank } }
  schedule walk -> cross
  phase walk { move each agent }
  phase cross {
    when side is home and count(agent on pier where agent chose pull) > 0 and count(agent on pier) <= count(quay) {
      set side = away
      each agent on pier { send agent to quay otherwise stay  tally ferried for agent }
    } otherwise when side is away and count(agent on quay where agent chose pull) > 0 and count(agent on quay) <= count(pier) {
      set side = home
      each agent on quay { send agent to pier otherwise stay  tally ferried for agent }
    }
  }
  metrics { event ferried }
  checks {
    always side is home or count(agent on pier) == 0
    always side is away or count(agent on quay) == 0
  }
  variant fault "whoever does not pull when another does is dropped" {
    phase cross {
      when side is home and count(agent on pier where agent chose pull) > 0 and count(agent on pier) <= count(quay) {
        set side = away
        each agent on pier where agent chose pull { send agent to quay otherwise stay  tally ferried for agent }
      } otherwise when side is away and count(agent on quay where agent chose pull) > 0 and count(agent on quay) <= count(pier) {
        set side = home
        each agent on quay { send agent to pier otherwise stay  tally ferried for agent }
      }
    }
  }
}
