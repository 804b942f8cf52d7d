sj 1
game every_draw "Every kind of draw, each kept where it can be counted" {
  param rare : probability = 0.02
  param odds : probability = { low: 0.1, high: 0.6 }
  episode 10

  kind floor "f" {
    field sort : { low, high } = low
    glyph "F" with sort = high
    field hit    : { no, yes } = no
    field tabled : { no, yes } = no
    field chain  : { none, early, later, last } = none
    field number : 0 .. 6 = 0
    field wide   : 0 .. 999 = 0
    field colour : { red, green, blue } = red
    field burden : { light, middle, heavy } = light
    field picked : { no, yes } = no
    field some   : { no, yes } = no
    field part   : reward
  }
  kind ring  "r"
  kind home  "h"
  kind gate  "g"
  kind den   "d" { field guest : agent  field taker : agent }
  kind gap   "."
  map { "fFfFf.r.ggg"
        "FfFfFrrrggg"
        "fFfFf.r.ddd"
        "hhhhhhh.ddd" }

  agents 6 {
    acts stay, forward, step_right, backward, step_left
    moves compass
    field partner : agent
    field came    : { no, yes } = no
    field faced   : { north, east, south, west } = north
  }

  phase start { each agent { send agent to home } }
  schedule tick -> come_back -> chances -> numbers -> pick_one -> pick_some -> meet -> lots -> walk -> note -> leave

  phase come_back {  # before they are sent again, at once
    each agent on den as place {
      set place.guest = agent
      set agent.faced = agent.heading
    }
  }
  phase chances {
    each floor {
      chance rare { set floor.hit = yes }
      chance odds[floor.sort] { set floor.tabled = yes }
      chance 0.3 { set floor.chain = early }
      otherwise chance 0.5 { set floor.chain = later }
      otherwise chance 0.2 { set floor.chain = last }
    }
  }
  phase numbers {
    each floor {
      draw number from 0 .. 6
      draw wide from 0 .. 999
      draw colour from { red, green, blue }
      draw burden from { light: 0.15, middle: 0.6, heavy: 0.25 }
      draw part from -1.0 .. 3
      set floor.number = number
      set floor.wide = wide
      set floor.colour = colour
      set floor.burden = burden
      set floor.part = part
    }
  }
  phase pick_one { pick 1 floor where floor.sort is high { set floor.picked = yes } }
  phase pick_some { pick 3 floor where floor.sort is low { set floor.some = yes } }
  phase meet {
    match agent as one with agent as two where one.index < 4 and two.index < 4 { set one.partner = two }
  }
  phase lots {
    each den as place { each agent as one where one.index < 4 { set place.taker = one by lot } }
  }
  phase walk { move each agent }
  phase note { each agent where agent.moved { set agent.came = yes } }
  phase leave {
    when step <= 1 {
      each agent {
        when agent.index < 4 { send agent to gate }
        otherwise { send agent to den after case step { 0: 1, 1..: 0 } }
      }
    }
  }
  observe {
    hide floor.hit  hide floor.tabled  hide floor.chain  hide floor.number  hide floor.wide  hide floor.colour
    hide floor.burden  hide floor.picked  hide floor.some
  }
}
