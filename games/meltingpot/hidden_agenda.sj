sj 1
game hidden_agenda "Hidden Agenda" {
  cite "Agapiou et al. 2022"
  about summary "Crewmates carry gems to a grate, and an impostor among them freezes them one by one. After a while, or when somebody sees"
                "the impostor fire, all who are left gather and vote: whoever has half of the votes is out. All of a side win or lose together."
  about our_paradigm "team competition"        # ours: zero-sum between the sides, of which one does not know the other
  about our_multi_task "yes"                   # ours: gathering, watching, deceiving, voting
  size players : count = 5 in 3 .. 7           # Melting Pot: five; ours: seats for the others
  size goal    : count = 32                    # Melting Pot: gems that win for the crewmates
  param length : steps = 3000  episode length  # Melting Pot
  param stake  : reward      = 1               # Melting Pot: to each of the side that wins, and taken from each of the other
  param regrow : probability = 0.001           # Melting Pot
  param charge : steps       = 50 in 0 .. 200  # Melting Pot: at the start; one step longer after a vote
  param pause  : steps       = 50 in 0 .. 255  # Melting Pot: after a shot
  param play : steps = 200 in 1 .. 1000  param vote_time : steps = 25 in 1 .. 1000  # Melting Pot: until a vote; how long it takes

  kind floor "."  kind wall "#" { blocks agents }  # Melting Pot: the beam passes through
  kind vein "G" { field gem : { none, gem } = gem }
  kind grate "O"  kind start_point "P"
  kind seat "V"  kind jail "D"  map "maps/hidden_agenda.txt"
  field round : { playing, voting } = playing  field delivered : 0 .. goal capped = 0
  timer clock  # until the vote begins, or ends

  agents players {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, tag, vote(whom : agent), abstain
    moves relative  field role : { crewmate, impostor } = crewmate
    field state : { active, frozen, out } = active  field struck : { no, yes } = no  field gem : { none, gem } = none
    field badge  : 0 .. players = 0        # its colour: its number, known to all
    field ballot : 0 .. players = players  # whom it votes for; players: nobody
    timer charging  forbid all when agent.state is not active
    forbid turn_left, turn_right, step_left, step_right, forward, backward when round is voting
    forbid tag when agent.role is crewmate or agent.charging > 0 or round is voting
    forbid vote, abstain when round is playing
  }
  shape beam { "..x.."  ".xxx."  "xx^xx" }          # Melting Pot: length 2 and radius 2, the outer lanes shorter
  define sees(one, other_one) = case one.heading {  # Melting Pot: the window
    north: within(one.row, other_one.row, 9, 1) and within(one.col, other_one.col, 5, 5),
    south: within(one.row, other_one.row, 1, 9) and within(one.col, other_one.col, 5, 5),
    west: within(one.col, other_one.col, 9, 1) and within(one.row, other_one.row, 5, 5),
    east: within(one.col, other_one.col, 1, 9) and within(one.row, other_one.row, 5, 5) }
  define within(here, there, less, more) = there + less >= here and there <= here + more
  define between(place, a, b) = distance(a, place) == 1 and distance(place, b) == 1 and (a.row == b.row or a.col == b.col)
  define hidden(a, b) = count(wall as w in diamond(1) of b where between(w, a, b)) + count(agent as c where between(c, a, b)) > 0
  define targets(a) = count(agent as b in beam of a where not hidden(a, b))  # Melting Pot: rays, which walls and players stop
  define left = count(agent where agent.state is active)
  define votes(one) = count(agent as a where a.state is active and a.ballot == one.index)
  define half(one) = 2 * votes(one) >= left and left > 0
  define chosen(one) = half(one) and count(agent as a where half(a) and a.index < one.index) == 0
  define crew = count(agent where agent.role is crewmate and agent.state is active)
  define impostors = count(agent where agent.role is impostor and agent.state is active)
  define crew_wins = delivered == goal or impostors == 0
  define sided(one) = case crew_wins { yes: one.role is crewmate, no: one.role is impostor }

  phase start {
    each agent {
      send agent to start_point  set agent.badge = agent.index  set agent.charging = charge
      when agent.index == players - 1 { set agent.role = impostor }  # Melting Pot
    }
    set clock = play
  }
  schedule grow -> tick -> walk -> gather -> fire -> adjourn -> ballot -> freeze -> verdict
  phase grow { each vein where vein.gem is none { chance regrow { set vein.gem = gem } } }
  phase walk { move each agent }
  phase gather {
    each agent on vein where vein.gem is gem and agent.gem is none { set vein.gem = none  set agent.gem = gem  tally collected for agent }
    each agent on grate where agent.gem is gem { set agent.gem = none  add 1 to delivered  tally deposited for agent }
  }
  phase fire {
    each agent as a where a chose tag {
      mark beam of a  set a.charging = pause
      first agent as b in beam of a { when b.state is active { set b.struck = yes  tally tagged for a } }
      when count(agent as b where b is not a and b.state is active and sees(b, a)) > targets(a) { set clock = 0 }
    }
  }
  phase ballot {  # Melting Pot: those of the step in which the vote ends come too late
    each agent as a where a chose vote and round is voting { set a.ballot = a.vote.whom.index  tally voted for a }
    each agent as a where a chose abstain and round is voting { set a.ballot = players }
  }
  phase adjourn {
    when clock == 0 and round is playing {
      set round = voting  set clock = vote_time  tally votes_held
      each agent where agent.state is active { set agent.ballot = players  send agent to seat }
    }
    when clock == 0 and round is voting {
      set round = playing  set clock = play  each agent { set agent.ballot = players }
      each agent as a where a.state is active {
        when chosen(a) { set a.state = out  send a to jail  tally voted_out for a }
        otherwise { set a.charging = charge + 1  send a to start_point }
      }
    }
  }
  # Melting Pot: whoever a vote has carried off, too
  phase freeze { each agent where agent.struck is yes { set agent.struck = no  set agent.state = frozen } }
  phase verdict {
    when crew_wins or crew <= 1 {
      each agent { give case sided(agent) { yes: 1, no: -1 } * stake to agent }
      tally won by case crew_wins { yes: 1, no: 0 }  tally lost by case crew_wins { yes: 0, no: 1 }  end
    }
  }
  observe {
    window ahead 9, behind 1, left 5, right 5  # Melting Pot
    show agent.role  show agent.gem  show agent.state  show agent.charging  show agent.badge  show other.badge  show other.state
    show everyone.ballot  show everyone.state  # Melting Pot: known to all at once
  }
  metrics { event collected  event deposited  event tagged  event voted  event votes_held  event voted_out  event won  event lost }
  checks {
    always count(agent where agent.role is crewmate and agent.charging > charge + 1) == 0
    expect tagged == 0 with never(tag) over 5 episodes
    conserved count(agent where agent.role is impostor)  always deposited <= collected
    expect deposited > 0 with cooperator over 1 episodes
  }
  policy cooperator "carries gems to the grate" {
    seek grate where agent.gem is gem  seek vein where agent.gem is none and vein.gem is gem
  }
  policy defector "fires at crewmates if it can, else carries gems, too" {
    aim beam at agent as other where agent.role is impostor and agent.charging == 0 and other.state is active choose tag
    seek grate where agent.gem is gem  seek vein where agent.gem is none and vein.gem is gem
  }
  variant by_lot "the impostor is drawn by lot" {
    phase start {
      each agent { send agent to start_point  set agent.badge = agent.index  set agent.charging = charge }
      pick 1 agent { set agent.role = impostor }  set clock = play
    }
  }
}
