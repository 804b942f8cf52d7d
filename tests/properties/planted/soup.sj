sj 1
game soup "Three onions make a soup, which is carried to the hatch on a plate" {
  param cooking : steps = 3 in 1 .. 20
  episode 300
  kind floor "."
  kind counter "#" { blocks agents }
  kind crate "O" { blocks agents }
  kind rack "D" { blocks agents }
  kind hatch "S" { blocks agents }
  kind pot "P" { field onions : 0 .. 3 capped = 0  field soup : { no, yes } = no  field cooks : set of agent  timer heat  blocks agents }
  map { "#O####D#"
        "#......#"
        "#..P...#"
        "##S##O##" }
  agents 3 {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, use
    moves relative
    field holds : { nothing, onion, plate, soup } = nothing
  }
  shape reach = line(1)
  field stocked : 0 .. 3000 capped = 0
  field taken   : 0 .. 3000 capped = 0
  phase start { each agent { send agent to floor } }
  schedule walk -> onion -> plate -> come -> fill -> cook -> take -> leave -> serve -> tick
  phase walk { move each agent }
  phase onion { each agent where agent chose use and agent.holds is nothing { first crate in reach of agent { set agent.holds = onion } } }
  phase plate { each agent where agent chose use and agent.holds is nothing { first rack in reach of agent { set agent.holds = plate } } }
  phase come { each agent as cook where cook chose use { first pot in reach of cook { add cook to pot.cooks } } }
  phase fill {
    each pot where pot.onions < 3 {
      pick 1 agent as cook in pot.cooks where cook.holds is onion {
        set cook.holds = nothing  add 1 to pot.onions  add 1 to stocked
        when pot.onions == 2 { set pot.heat = cooking }
      }
    }
  }
  phase cook { each pot where pot.onions == 3 and pot.heat == 0 { set pot.soup = yes } }
  phase take {
    each pot where pot.soup is yes {
      pick 1 agent as cook in pot.cooks where cook.holds is plate {
        set cook.holds = soup  set pot.soup = no  set pot.onions = 0  add 1 to taken
      }
    }
  }
  phase leave { each pot { set pot.cooks = nobody } }
  phase serve {
    each agent where agent chose use and agent.holds is soup {
      first hatch in reach of agent { set agent.holds = nothing  tally served for agent  give 20 to all }
    }
  }
  metrics { event served }
  checks { always 3 * taken <= stocked }
  variant fault "two who take the soup in one step both have it" {
    phase take {
      each pot where pot.soup is yes {
        each agent as cook in pot.cooks where cook.holds is plate {
          set cook.holds = soup  set pot.soup = no  set pot.onions = 0  add 1 to taken
        }
      }
    }
  }
}
