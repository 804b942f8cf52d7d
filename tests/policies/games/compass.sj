sj 1
game compass "Compass moves on a map wider than a word" {
  episode 40
  kind floor "." { field stock : 0 .. 3 capped = 0 }
  kind rock  "O" { field ore : { none, gold } = gold }
  kind wall  "#" { blocks agents, beam }
  map { "........................................"
        "..######.........OO........######......."
        "..#....#....................#...#......."
        "..#..O.#....######..........#.O........."
        "........................................" }
  agents 4 {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, dig, call
    moves compass
  }
  shape beam = fan(3, 1)
  phase start { each agent { send agent to floor } }
  schedule walk -> work
  phase walk { move each agent }
  phase work {
    each agent as one where one chose dig { each rock in beam of one where rock.ore is gold { set rock.ore = none } }
    each agent on floor where agent chose call { add 1 to floor.stock }
  }
  observe { window ahead 2, behind 2, left 2, right 2 }
  policy digger { aim beam at rock where rock.ore is gold choose dig  when yes_now choose call }
  policy keeper {
    when min(distance(agent, other) over agent as other where other is not agent otherwise 40) < 8 choose dig
    when max(distance(agent, rock) over rock) > 20 choose call
  }
  define yes_now = step >= 0
  policy walker {
    seek floor where floor.row == 0 and floor.col == 39 avoiding floor where floor.row == 4  seek floor where floor.stock > 0
  }
}
