# A cell picked around the cell of an outer sentence was looked for along the axis of the inner one.
sj 1
game found "Found" {
  episode 30
  kind grass "."
  kind tree  "t" { field fans : 0 .. 9 capped = 0 }
  map { "t.t"  ".t." }
  agents 1 { acts forward, turn_left, stay }
  phase start { each agent { send agent to grass } }
  schedule grow
  phase grow {
    each grass where nobody on grass {
      each tree as other in disc(1) of grass {
        pick 1 tree in square(1) of grass { let some = tree.fans  tally seen by some }
        add 1 to other.fans
      }
    }
  }
  metrics { event seen }
}
