# A whole row set to that of the cell that a `first` finds: the row was taken for one value, and spread over its words.
sj 1
game found {
  episode 20
  kind pond "."
  kind rock "#" { field fruit by { ripe, blue } : 0 .. 9 = 1 }
  map { "....#"  ".##.."  "#...."  "#...." }
  agents 1 { acts forward, stay }
  phase start { each agent { send agent to pond } }
  schedule ripen -> share
  phase ripen {
    each rock {
      draw number from 0 .. 9
      draw word from { ripe, blue }
      set rock.fruit[word] = number
    }
  }
  phase share {
    each rock as mine {
      first rock in square(1) of mine { set mine.fruit = rock.fruit }
    }
  }
}
