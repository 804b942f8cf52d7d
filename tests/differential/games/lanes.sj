sj 1
game lanes "Lanes, groups and blocking" {
  size players : count = 5 in 2 .. 8
  episode 40
  kind floor "."
  kind wall  "#" { blocks agents, fork, sweep }
  kind door  "D" { field state : { shut, open } = shut  blocks agents, fork when door.state is shut }
  kind plot  "p" { field crop : { none, seed, ripe } = none  field worth : 0 .. 9 = 1  glyph "q" with crop = ripe }
  kind pond  "o" { field crop : { none, seed, ripe } = seed }
  kind home  "H"
  group field_of = plot, pond
  map { "H.p#pD.q"
        "..oo..p."
        "H.#pq#oH"
        "pD..oo.p"
        "H.q.p.#H" }
  agents players {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, peer, cut
    moves relative
    field score : 0 .. 20 capped = 0
    field team  : { red, blue } = red
    blocks fork when agent.team is blue
    blocks sweep
  }
  shape fork { "x.x"
               "x.x"
               "x^x"
               ".x." }
  shape sweep = fan(3, 1)
  phase start { each agent { send agent to home facing east  when agent.index % 2 == 1 { set agent.team = blue } } }
  schedule toggle -> walk -> see -> sow -> reap -> near -> rest
  phase toggle { each door { chance 0.3 { set door.state = case door.state { shut: open, open: shut } } } }
  phase walk { move each agent where agent.team is red or step % 2 == 0 }
  phase see {
    each agent as looker where looker chose peer {
      mark fork of looker
      first agent as seen in fork of looker where seen.team is not looker.team { add 1 to looker.score  tally sights for looker }
      when count(agent as seen in fork of looker where seen.team is not looker.team) == 0 { tally blanks for looker }
      first plot in sweep of looker where plot.crop is ripe { set plot.crop = none  add 2 to looker.score  tally cuts for looker }
    }
  }
  phase sow {
    each field_of where field_of.crop is none and nobody on field_of {
      let around = count(field_of as other in disc(2) of field_of where other.crop is ripe)
      chance case around { 0: 0.05, 1: 0.2, 2..: 0.5 } { set field_of.crop = seed } otherwise chance 0.1 { set field_of.crop = ripe }
    }
  }
  phase reap {
    each agent on field_of where field_of.crop is ripe { set field_of.crop = none  give 1 to agent  tally reaped for agent }
    each agent as cutter where cutter chose cut { each plot in sweep of cutter where plot.crop is seed { set plot.crop = ripe } }
  }
  phase near {
    each agent {
      let friends = count(agent as other in square(2) of agent where other.team is agent.team)
      let water = sum(1 over pond in diamond(1, centre) of agent)
      give friends + 0.5 * water to agent
    }
    each plot { let visitors = count(agent in disc(1) of plot)  set plot.worth = min(9, visitors * 2) }
  }
  phase rest { each agent on home where agent.score > 3 { set agent.score = 0  give 0.25 to all but agent } }
  observe {
    window ahead 4, behind 2, left 2, right 3  show agent.score  show other.team when other.team is not agent.team
    show home as { floor }  show wall as { outside }
    show pond as { floor where pond.crop is none, sown where pond.crop is seed and agent.score > 2, pond_ }
    hide marks on door when door.state is shut  hide marks on plot when agent.score < 3 and plot.crop is not ripe  hide marks on home
    hide marks on agents  hide content on agents  show everyone.score
    show everyone.team as { mine where everyone.team is agent.team, theirs }
  }
  metrics {
    event sights
    event blanks
    event cuts
    event reaped
    mean ripe = count(field_of where field_of.crop is ripe)
    final doors = count(door where door.state is open)
  }
}
