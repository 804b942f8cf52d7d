# A word that is the same for all agents, counted for each of them, was added to the table of agents and words as a row without agents.
sj 1
game found "Found" {
  episode 30
  field sort : { apple, pear, plum } = pear
  kind grass "." { field ripe : { apple, pear, plum } = plum }
  map { "..."  "..." }
  agents 1 { acts forward, turn_left, stay }
  phase start { each agent { send agent to grass } }
  schedule counting
  phase counting { each agent where agent chose forward { tally seen[sort] for agent }  set sort = plum }
  metrics { event seen by { apple, pear, plum } }
}
