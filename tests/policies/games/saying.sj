sj 1
game saying "Policies choose actions with arguments" {
  episode 40
  kind grass "."
  kind door  "D"
  map { "....D"
        ".D..." }
  agents 3 {
    acts stay, forward, backward, step_left, step_right, vote(agent), offer(apples : 0 .. 2, pears : -1 .. 1), say({ red, green })
    moves compass
    field friend : agent
    field apples : 0 .. 2 = 0
    field heard  : { none, red, green, blue } = none
    forbid vote(who) when who is agent
  }
  phase start { each agent { send agent to grass } }
  schedule walk -> act
  phase walk { move each agent }
  phase act {
    each agent { draw n from 0 .. 2  set agent.apples = n  draw word from { none, red, green, blue }  set agent.heard = word }
    each agent as a { pick 1 agent as b where b is not a { set a.friend = b } }
    each agent where agent chose vote or agent chose offer or agent chose say { give 1 to agent }
  }
  policy voter "votes for its friend" {
    when agent.friend is not nobody and agent.apples > 0 choose vote(agent.friend)
    when agent.apples == 0 and agent.index == 1 choose vote(2)
  }
  policy trader "offers what it has" {
    when agent.apples < 2 choose offer(agent.apples + 1, -agent.apples)
    when agent.heard in { red, green } choose offer(2, 1)
  }
  policy crier "says what it heard, at a door" {
    when agent.heard in { red, green } choose say(agent.heard)
    aim disc(1) at door avoiding grass as g where g.col == 2 choose offer(agent.apples, 0)
  }
}
