# The interpreter added 8,000 rewards one after the other and rounded each time: off by 1e-5 and more, where the compiled game multiplies.
sj 1
game thousands_of_additions "Every tree of three gives a little" {
  episode 25
  kind tree "T"
  map {
    "TTTTT"
    "TTTTT"
    "TTTTT"
    "TTTTT"
  }
  field store : reward = 0
  metrics { mean weight = sum(0.1 over tree as one) }
  agents 2 { acts stay }
  schedule yield
  phase start { each agent { send agent to tree } }
  phase yield {
    each tree as one {
      each tree as two {
        each tree as three {
          give 0.1 to all
          add 0.1 to store
        }
      }
    }
  }
  observe { show other.index }
}
