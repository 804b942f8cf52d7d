# compiler: AssertionError where a statement inside a `pick` of no cell at all wrote what differs from cell to cell
sj 1
game picks "Nothing is picked" {
  episode 25
  kind grass "." { field fruit : { none, ripe } = none }
  field pot   : { low, high } = low
  field found : { no_one, somebody } = somebody
  map { "...."  "...." }
  agents 3 {
    acts stay, forward
    moves compass
  }
  phase start { each agent { send agent to grass } }
  schedule walk -> rule
  phase walk { move each agent }
  phase rule {
    pick 7 % 1 grass where grass.col > 0 {
      set pot = case nobody on grass { yes: high, no: low }
      set grass.fruit = ripe
    } otherwise { set found = no_one }
  }
}
