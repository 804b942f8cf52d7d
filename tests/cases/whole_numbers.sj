sj 1
game whole_numbers "Whole numbers, conditions on all members, what is shown beside fields, checks of steps" {
  param pace : number      = 1.5 in 0 .. 4
  param pay  : reward      = 1
  param luck : probability = 0.25
  episode 20
  kind grass "."
  kind tree  "T" { field fruit : 0 .. 9 capped = 3 }
  map { "..TT" }
  agents 2 {
    acts stay, eat
    field bag : 0 .. 9 capped = 0
  }
  phase start { each agent { send agent to grass } }
  schedule eat -> end_of_day
  phase eat {
    each agent where agent chose eat and any (tree where tree.fruit > 0) {
      draw many from { 1: luck, 4: 1 - luck }
      add many to agent.bag
      give pay * quotient(agent.bag, 2) to agent
    }
    each tree { add round(pace) - 2 to tree.fruit }
  }
  phase end_of_day { when all (tree where tree.fruit == 0) { end } }
  define fives = quotient(step, 5)
  observe { window ahead 1, behind 0, left 1, right 1  show step  show fives }
  checks { always all (agent where before(agent.bag) <= agent.bag) }
}
