sj 1
game neighbours "Growth that depends on how many neighbours are ripe" {
  param slow : probability = 0.1
  param fast : probability = 0.5
  episode 10
  kind tree "T" { field fruit : { none, ripe } = ripe  glyph "t" with fruit = none }
  map {
    "TtT"
    "ttt"
  }
  agents 1 { acts stay }
  phase start { each agent { send agent to tree } }
  schedule grow
  phase grow {
    each tree where tree.fruit is none and nobody on tree {
      let near = count(tree as other in disc(1) of tree where other.fruit is ripe)
      chance case near { 0: 0, 1: slow, 2..: fast } { set tree.fruit = ripe }
    }
  }
  metrics { mean ripe = count(tree where tree.fruit is ripe) / count(tree) }
}
