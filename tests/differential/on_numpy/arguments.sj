sj 1
game arguments "Actions with arguments: votes, offers and signals" {
  size  most  : count  = 2
  param worth : reward = 0.5
  episode 20
  kind seat "s" { field holder : agent  field last : { none, red, green, blue } = none }
  kind door "D"
  map { "sssD"
        "sDsD" }
  agents 4 {
    acts vote(agent), stay, offer(apples : 0 .. most, pears : -1 .. 1, 0 .. 1), say({ red, green }), point(whom : agent, how : { red,
        blue })
    moves compass
    field votes  : 0 .. 4 = 0
    field apples : 0 .. 9 capped = 1
    field pears  : -9 .. 9 capped = 0
    field heard  : { none, red, green, blue } = none
    field friend : agent
    forbid vote(who) when who is agent or who.away or who.votes > 3
    forbid offer(a, some, 1) when a > agent.apples or step > 12
    forbid say(red), point when step < 2
    forbid point(x, blue) when agent.friend is not x and agent.votes > 1
  }
  define agrees(a, b) = a chose offer and b chose offer(a.offer.apples, -a.offer.pears, 1)
  phase start { each agent { send agent to seat facing north } }
  schedule tick -> speak(say) -> trade -> count_votes -> follow -> exclude
  phase speak(deed) {
    each agent where agent chose deed { set agent.heard = agent.say }
    each agent as a on seat where a chose point and a.point.whom is not a {
      let seen = a.point.whom
      set seat.last = a.point.how
      set seat.holder = seen
      when seen.votes > 0 { give 1 to seen }
    }
  }
  phase trade {
    match agent as a with agent as b where agrees(a, b) {
      add a.offer.pears to a.pears
      add b.offer.pears to b.pears
      set a.friend = b
      set b.friend = a
      tally deals[green] for a
    }
    each agent as a where a chose offer(1, 0, 0) or a chose offer(a.votes, a.pears, a.apples) { give 2 to a }
    each agent as a where a chose offer(sum(2 over door as d), 0, 0) { give 9 to a }  # six apples: more than can be offered
  }
  phase count_votes {
    each agent as x { set x.votes = count(agent as v where v chose vote(x)) }
    each agent as v where v chose vote { give worth * v.vote.apples to v  tally deals[v.vote.heard] for v.vote }
    each agent as a where a chose point(a, red) or a chose vote(0) and not a chose say { add 1 to a.apples }
  }
  phase follow {
    each agent as a where a chose point { each agent as b in a.point.whom where b chose say(a.point.how) { give -1 to b } }
    each agent as a where a.friend is not nobody { when a chose vote(a.friend) { give 5 to a.friend } }
    each agent as a where a chose say(a.heard) { each agent as b where b chose say(a.say) and b is not a { give 0.5 to b } }
  }
  phase exclude {
    each agent where agent.votes > 1 { send agent to seat after 2 otherwise stay }
  }
  metrics { event deals by { none, red, green, blue } }
  checks { symmetric agents }
  policy voter "votes for its friend" {
    when agent.friend is not nobody and agent.apples > 0 choose vote(agent.friend)
    when agent.heard in { red, green } and agent.votes < 1 choose offer(agent.votes, 1, 0)
    aim disc(1) at door choose say(green)
    when step > 5 choose point(2, blue)
  }
}
