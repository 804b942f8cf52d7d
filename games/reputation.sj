sj 1
game reputation "Reputation" {
  cite "Nowak and Sigmund 1998, whose image scores are opinions of each about each here"
  about summary "Neighbours in a ring of houses now and then fall ill, and who is well can nurse one who lives near by, at a cost. All"
                "neighbours see who helps and who looks away, and each keeps its own opinion of everybody."
  about our_paradigm "indirect reciprocity"  # ours: others pay help back, if they have seen it and care
  about our_long_term_impact "yes"           # ours: opinions last
  about our_multi_task "no"                  # ours: to help or not is the only decision

  size  players : count       = 6 in 2 .. 40    # ours: few enough to be neighbours
  size  best    : count       = 5 in 2 .. 9     # ours: the highest opinion
  size  street  : cells       = 2 in 1 .. 9     # ours: from so near one is seen, and nursed
  param length  : steps       = 200             # ours: each is ill some six times
  param illness : probability = 0.05 in 0 .. 1  # ours: of each who is well, in each step
  param brief   : probability = 0.5 in 0 .. 1   # ours: that it lasts four steps, and not eight
  param least   : reward      = 2 in 0 .. 100   # ours: what help is worth is drawn; b of the source
  param most    : reward      = 6 in 0 .. 100   # ours: at most this
  param effort  : reward      = 1 in 0 .. 100   # ours: c of the source; who nurse one together share it
  param credit  : number      = 2 in 1 .. 9     # ours: who has more than best / credit is in good standing

  param patience by 0 .. 3 : reward = { 0: 0, 1 .. 2: -0.1, 3: -0.2 }  # ours: of each step in pain, by how many there were

  param newcomer by agent : count = { otherwise: 3 }  # ours: what is thought of each at the start
  episode length

  kind house "h"
  map wraps { "hhhhhh" }
  agents players {
    acts stay, nurse(agent)
    field opinion by agent : 0 .. best capped = 3  field neighbours : set of agent  # ours: `newcomer` replaces the 3
    field health : { well, ill } = well  field relief : reward  field days : 0 .. 3 capped = 0  timer fever  # ours: as far as patience goes
    field patient : agent  # one in need of whom it thinks well
    forbid nurse(who) when not (who in agent.neighbours) or who.health is well  forbid nurse when agent.health is ill
  }
  define nurses(b)    = count(agent as a where a chose nurse(b))
  define trusts(a, b) = credit * a.opinion[b] > best

  phase start { each agent as a { send a to house where house.col == a.index facing north } }
  schedule meet -> nurse -> judge -> ache -> recover -> fall_ill -> choose_ -> tick

  phase meet {
    each agent as a where step == 0 {
      each agent as b { set a.opinion[b] = min(newcomer[b], best) }
      each agent as b where b is not a and distance(a, b) <= street { add b to a.neighbours }
    }
  }
  phase nurse {
    each agent as b where b.health is ill and nurses(b) > 0 {
      give b.relief to b  tally healed for b  set b.fever = 0
      each agent as a where a chose nurse(b) { give -effort / nurses(b) to a  tally nursed[b] for a }
    }
  }
  phase judge {  # who looks away from somebody in good standing loses it
    each agent as a {
      each agent as b in a.neighbours where b.health is well {
        when b chose nurse { add 1 to a.opinion[b] }
        otherwise when any (agent as c in b.neighbours where c.health is ill and trusts(a, c)) {
          add -1 to a.opinion[b]  tally blamed for b
        }
      }
    }
  }
  phase ache { each agent where agent.health is ill { give patience[agent.days] to agent  add 1 to agent.days } }
  phase recover { each agent where agent.health is ill and agent.fever == 0 { set agent.health = well } }
  phase fall_ill {
    each agent where agent.health is well {
      chance illness {
        draw relief from least .. most  draw fever from { 4: brief, 8: 1 - brief }  # ours: long enough to be helped
        set agent.relief = relief  set agent.fever = fever  set agent.days = 0  set agent.health = ill  tally illnesses for agent
      }
    }
  }

  phase choose_ {
    each agent as a {
      pick 1 agent as b in a.neighbours where b.health is ill and trusts(a, b) { set a.patient = b } otherwise { set a.patient = nobody }
    }
  }

  define decade      = min(quotient(step, 10), 255)  # ours: a byte
  define standing(b) = round(10 * sum(a.opinion[b] over agent as a) / (players * best))  # ours: in tenths
  observe {
    window ahead 0, behind 0, left 2, right 2 when agent.health is well  # ours: the street
    window ahead 0, behind 0, left 1, right 1                            # the ill see those next door
    show agent.opinion  show agent.health  show decade  show other.health when distance(agent, other) <= street
    hide agent.relief  hide agent.days
  }
  metrics { event illnesses  event healed  event nursed by agent  event blamed  final standing = sum(standing(agent) over agent) / players }
  checks {
    require least <= most
    require least > effort  # help is worth more than it costs
    always all (agent where agent.days in 0 .. 3)
    always illnesses >= healed and before(illnesses) <= illnesses
    expect healed == 0 with never(nurse) over 5 episodes
    expect healed > 0 with cooperator over 5 episodes
    expect healed == 0 with defector over 5 episodes
  }
  policy cooperator "nurses neighbours of whom it thinks well" {
    when agent.patient is not nobody choose nurse(agent.patient)
  }
  policy defector "never nurses" { when agent.health is well choose stay }
  scenario newcomer "a newcomer among those who nurse" { slots 1 focal  slots players - 1 policy cooperator }
  scenario residents "residents meet one who never nurses" { slots players - 1 focal  slots 1 policy defector }
  variant village "forty houses" {
    set players = 40  # ours: more than a machine word has bits
    map wraps { "hhhhhhhhhhhhhhhhhhhhhhhhhhhhhhhhhhhhhhhh" }
  }
}
