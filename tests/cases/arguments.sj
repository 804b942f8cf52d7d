sj 1
game arguments "Actions with arguments" {
  episode 10
  kind seat "s"
  map { "ssss" }
  agents 3 {
    acts vote(agent), stay, offer(apples : 0 .. 1, pears : -1 .. 1), say({ red, green })
    field votes : 0 .. 3 = 0
    field heard : { none, red, green } = none
    forbid vote(who) when who is agent or who.away
    forbid offer(1, p) when p > agent.votes
    forbid say(red) when step < 2
  }
  phase start { each agent { send agent to seat } }
  schedule act
  phase act {
    each agent as a { set a.votes = count(agent as v where v chose vote(a)) }
    each agent as a where a chose say { set a.heard = a.say }
    each agent as a where a chose vote { give 1 to a.vote }
    match agent as a with agent as b where a chose offer and b chose offer(a.offer.apples, -a.offer.pears) { give a.index + 1 to b }
    each agent as a where a chose vote(0) or a chose offer(1, 0) { tally special }
  }
  metrics { event special }
  policy friend { when agent.heard is red choose say(green)  when step > 3 choose vote(1) }
  policy pedlar { aim line(2) at agent as buyer choose offer(1, 0)  aim line(1) at agent as buyer choose say(red) }
}
