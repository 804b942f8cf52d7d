# A cell was in two pairs, once on each side: only agents were kept from that.
sj 1
game found {
  episode 20
  kind grass "." { field met : 0 .. 9 capped = 0 }
  kind gate  "P"
  map { "..."  ".PP" }
  agents 2 { acts forward, stay }
  phase start { each agent { send agent to gate } }
  schedule meet
  phase meet {
    match grass as a with grass as b {
      add 1 to a.met
      add 2 to b.met
      give 1 to all
    }
  }
}
