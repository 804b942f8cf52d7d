sj 1
game moving "Movers: deer flee and are caught, a ball rolls, a cart rides a belt" {
  episode 10
  kind grass "." { field grown : { lush, bare } = lush }
  kind wall  "#" { blocks agents, deer, ball }
  kind belt  "=" { field way : { east, south } = east  glyph "|" with way = south  blocks ball, deer when belt.way is east }
  map {
    "...#"
    "==|."
    "...."
  }
  agents 1 {
    acts turn_left, turn_right, forward, stay, kick
    moves relative
  }
  movers deer 2 "d" { field owner : agent  timer rest }
  movers ball 1 "o" { field rolls : { no, yes } = no }
  movers cart 1 "c"
  phase start {
    each agent { send agent to grass facing east }
    each deer { send deer to grass facing south }
    each ball { send ball to grass }
    each cart { send cart to belt }
  }
  schedule tick -> walk -> flee -> roam -> roll -> stop -> ride -> act
  phase walk { move each agent }
  phase flee {
    move each deer where deer.rest == 0 away from agent as a where distance(a, deer) <= 2 avoiding grass where grass.grown is bare
  }
  phase roam { move each deer where deer.rest > 0 at random }
  phase roll { move each ball where ball.rolls is yes ahead }
  phase ride { move each cart on belt along belt.way }
  phase act {
    pick 1 agent where agent chose kick {
      first ball in line(1) of agent { set ball.rolls = yes  set ball.heading = agent.heading }
      when count(ball in line(1) of agent) == 0 {
        first deer in line(1) of agent {
          set deer.owner = agent
          set deer.rest = 4
          send deer to grass after 2
        }
      }
    }
  }
  phase stop { each ball where ball.rolls is yes and not ball.moved { set ball.rolls = no } }
  observe { window ahead 2, behind 1, left 1, right 1  show deer.heading  show ball.rolls  hide cart }
  checks { conserved count(ball)  symmetric deer }
  look deer                     as brown animal
  look deer where deer.rest > 0 with pot
}
