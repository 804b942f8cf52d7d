sj 1
game freeze "A catcher freezes the others, who can be thawed by a friend beside them" {
  episode 200
  kind ice  "."
  kind wall "#" { blocks agents, touch }
  map { "......"
        "..##.."
        "......" }
  agents 4 {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, touch
    moves relative
    field role    : { runner, catcher } = runner
    field frozen  : { no, yes } = no
    field helpers : set of agent
    forbid all when agent.frozen is yes
  }
  shape touch = line(1)
  phase start { each agent { when agent.index == 0 { set agent.role = catcher }  send agent to ice } }
  schedule walk -> catch -> help -> thaw -> rest
  phase walk { move each agent }
  phase catch {
    match agent as hunter with first agent as victim in touch of hunter where hunter chose touch and hunter.role is catcher
        and victim.frozen is no and victim.role is runner {
      set victim.frozen = yes  tally caught
    }
  }
  phase help {
    each agent as friend where friend chose touch and friend.role is runner {
      first agent as victim in touch of friend where victim.frozen is yes { add friend to victim.helpers }
    }
  }
  phase thaw {
    each agent where agent.helpers is not nobody { set agent.frozen = no  tally thawed  give 1 to agent.helpers }
  }
  phase rest { each agent { set agent.helpers = nobody } }
  metrics { event caught  event thawed }
  checks { always count(agent where agent.frozen is yes) == caught - thawed }
  variant fault "one whom two thaw counts twice" {
    phase thaw {
      each agent where agent.helpers is not nobody {
        set agent.frozen = no
        each agent as friend in agent.helpers { give 1 to friend  tally thawed }
      }
    }
  }
}
