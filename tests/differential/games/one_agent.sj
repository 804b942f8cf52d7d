sj 1
game one_agent "What one agent alone writes: by its number, or because the others may not" {
  episode 30
  kind grass "."
  kind tree  "T" { field height : 0 .. 9 = 0  field owner : agent  field seen : set of agent }
  map { "..T."  "T..." }
  agents 4 {
    acts turn_left, turn_right, forward, stay, call, shout
    moves relative
    field bag  : 0 .. 9 capped = 0
    field mood : { calm, wild, glad } = calm
    field have by { red, blue } : 0 .. 9 = 0
    forbid call when agent.index != 2
    forbid shout when agent.index > 0 or agent.bag > 6
  }
  field last    : agent
  field weather : { calm, wild, glad } = calm
  field level   : 0 .. 9 = 0
  field wealth  : reward = 0
  field told    by { red, blue } : 0 .. 9 = 0
  phase start { each agent { send agent to grass facing east } }
  schedule walk -> fill -> cheer -> speak -> lead
  phase walk { move each agent }
  phase fill {
    each agent on tree { add 1 to agent.bag  set agent.mood = wild }
    each agent as a where a chose turn_left { set a.have[red] = a.bag  set a.have[blue] = min(a.index, 9) }
  }
  phase cheer { each agent as a where a chose turn_left { set a.mood = glad } }
  phase speak {
    each agent as caller where caller chose call {
      set last = caller
      set level = caller.bag
      set weather = caller.mood
      set wealth = caller.bag * 0.5
      set told = caller.have
      each tree { set tree.height = caller.bag  set tree.owner = caller }
    }
    each agent as a {
      when a.index == 3 { each tree { add a to tree.seen } }
    }
  }
  phase lead {
    each agent where agent chose shout { when agent.bag > 1 { set last = agent  set told[red] = agent.bag } }
    each agent as a where a.index == 1 { each agent as b where b.index > 1 { set b.mood = a.mood } }
  }
  observe { window ahead 1, behind 0, left 1, right 1  show level  show weather  show agent.mood  show agent.have }
}
