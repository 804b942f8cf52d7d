# Which entry is set, asked of the cell that a `first` finds: the lane's axis stayed, and the field got one more.
sj 1
game found {
  episode 20
  kind pond "."
  kind rock "#" {
    field fruit by { ripe, blue, none } : 0 .. 1 = 1
    field age   : { ripe, blue, none } = ripe
  }
  map { "....#"  ".##.."  "#...."  "#...." }
  agents 1 { acts forward, stay }
  phase start { each agent { send agent to pond } }
  schedule ripen -> pick_fruit
  phase ripen {
    each rock {
      draw age from { ripe, blue, none }
      set rock.age = age
    }
  }
  phase pick_fruit {
    each rock as mine {
      first rock in square(1) of mine { set mine.fruit[rock.age] = 0 }
    }
  }
}
