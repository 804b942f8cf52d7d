sj 1
game lock "One boat at a time is let into a lock" {
  episode 200
  kind water "~" { blocks agents }
  kind quay  "="
  kind lock  "L" { blocks agents  blocks boat when boat.pass is none }
  map { "~~~=~~~"
        "~~LLL~~"
        "~~~=~~~" }
  agents 2 { acts turn_left, turn_right, forward, stay, call  moves relative }
  movers boat 3 "b" { field pass : { none, called, inside } = none }
  phase start {
    each agent { send agent to quay }
    each boat { send boat to water }
  }
  schedule leave -> walk -> call -> sail -> note
  phase walk { move each agent }
  phase call {
    when count(boat where boat.pass is not none) == 0 {
      pick 1 agent where agent chose call { pick 1 boat { set boat.pass = called } }
    }
  }
  phase sail { move each boat where boat.pass is not inside toward lock }
  phase note { each boat on lock { set boat.pass = inside } }
  phase leave {
    each boat where boat.pass is inside { chance 0.3 { send boat to water otherwise stay  set boat.pass = none } }
  }
  checks { always count(boat on lock) <= 1 }
  variant fault "a boat is called while the one called before has not come yet" {
    phase call {
      when count(boat on lock) == 0 {
        pick 1 agent where agent chose call { pick 1 boat { set boat.pass = called } }
      }
    }
  }
}
