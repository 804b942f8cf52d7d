# The interpreter read a condition of a chain after another one had held, and so what only its guard makes sure.
sj 1
game found "Found" {
  param luck : word   = low
  param fee  : reward = { low: 0, high: 1, glad: 2 }
  param gain : reward = { high: 1, glad: 2 }
  episode 30
  kind grass "." { field fruit : { low, high, glad } = low  field mood : { high, glad } = glad }
  map { "...." }
  agents 1 { acts stay }
  phase start { each agent { send agent to grass } }
  schedule grow
  phase grow {
    each grass {
      when luck is low { give fee[grass.fruit] to all }
      otherwise when not (gain[luck] > 1) { give 1 to all }
    }
  }
}
