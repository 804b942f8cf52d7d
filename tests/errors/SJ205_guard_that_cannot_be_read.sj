sj 1
game pond {
  episode 20
  kind shore "." { field fruit : { none, ripe } = none }
  kind water "~"
  field host : agent = nobody
  map { "...~"
        "...~" }
  agents 2 {
    acts turn_left, turn_right, forward, stay
    moves relative
    field holds : { raw, cut } = raw
  }
  phase start { each agent { send agent to shore } }
  schedule walk -> eat -> thank -> greet
  phase walk { move each agent }
  phase eat {
    each agent on shore where shore.fruit is raw and host is not nobody {
      when host.holds is raw { tally eaten for host }
    }
  }
  phase thank {
    pick 1 shore where shore.fruit is cut {
      each agent in square(1) of shore where host is not nobody { give 1 to host }
    }
  }
  phase greet {
    when host is nobody or host.holds is ripe { tally eaten }
    otherwise { give 1 to host }
  }
  observe { window ahead 2, behind 1, left 1, right 1 }
  metrics { event eaten }
}
