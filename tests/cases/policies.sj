sj 1
game policies "Scripted policies that read the state, walk and aim, and line-ups of them" {
  size players : count = 3
  episode 10
  kind grass "."
  kind wall  "#" { blocks agents, ray }
  kind tree  "T" { field fruit : { none, ripe } = ripe }
  map {
    "T.#T"
    "...."
  }
  agents players {
    acts turn_left, turn_right, forward, stay, zap
    moves relative
    field bag : 0 .. 2 capped = 0
  }
  shape ray = line(3)
  shape beside = disc(1)
  define sated(who) = who.bag == 2
  phase start { each agent { send agent to grass } }
  schedule walk -> eat -> work
  phase walk { move each agent }
  phase eat { each agent on tree where tree.fruit is ripe { set tree.fruit = none  add 1 to agent.bag  give 1 to agent } }
  phase work { each agent as one where one chose zap { each agent as two in ray of one { set two.bag = 0 } } }
  policy gatherer "eats, and rests with a full bag" {
    when sated(agent) choose stay
    seek tree where tree.fruit is ripe avoiding grass in beside of agent where grass.row == 0
  }
  policy bully {
    aim ray at agent as other where other.bag > agent.bag avoiding tree choose zap
    seek agent as other where other is not agent
    when step > 5 choose turn_left
  }
  scenario alone "one among bullies" { slots 1 focal  slots players - 1 policy bully }
  scenario mixed { slots players - 2 focal  slots 1 policy gatherer  slots 1 policy random }
  checks { expect 1 > 0 with gatherer, bully over 2 episodes }
}
