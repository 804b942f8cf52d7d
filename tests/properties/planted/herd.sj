sj 1
game herd "Deer that are hunted breed while one of them is left" {
  episode 200
  kind grass "."
  kind wood  "T" { blocks agents }
  map { "....."
        ".T.T."
        "....." }
  agents 2 { acts turn_left, turn_right, forward, stay, shoot  moves relative }
  movers deer 2 "d" { field hit : { no, yes } = no }
  field extinct : { no, yes } = no
  shape ray = line(2)
  phase start {
    each agent { send agent to grass }
    each deer { send deer to grass }
  }
  schedule walk -> roam -> shoot -> bury
  phase walk { move each agent }
  phase roam { move each deer at random avoiding wood }
  phase shoot { each agent as a where a chose shoot { first deer in ray of a { set deer.hit = yes } } }
  phase bury {
    when count(deer where deer.hit is no) == 0 { set extinct = yes }
    each deer where deer.hit is yes {
      set deer.hit = no
      give 1 to all
      when count(deer as other where other.hit is no) > 0 { send deer to grass otherwise stay } otherwise { remove deer }
    }
  }
  checks { once extinct is yes always count(deer) == 0 }
  variant fault "of the last two, shot in one step, each is reborn because the other lives" {
    phase bury {
      when count(deer where deer.hit is no) == 0 { set extinct = yes }
      each deer where deer.hit is yes {
        set deer.hit = no
        give 1 to all
        when count(deer as other) > 1 { send deer to grass otherwise stay } otherwise { remove deer }
      }
    }
  }
}
