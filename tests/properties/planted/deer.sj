sj 1
game deer "Deer move away from hunters; two who strike from different sides in one step bring one down" {
  episode 300
  kind wood   "w" { blocks agents }
  kind meadow "." {
    field deer : { no, yes } = no  field hunters : set of agent  glyph "d" with deer = yes  blocks agents when meadow.deer is yes
  }
  kind camp   "c"
  map { "cc......"
        ".....d.."
        "..d....."
        "....w..c" }
  agents 3 {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, strike
    moves relative
  }
  shape spear = line(1)
  field killed : 0 .. 1000 capped = 0
  phase start { each agent { send agent to camp } }
  schedule walk -> hunt -> fall -> flee -> rest
  phase walk { move each agent }
  phase hunt {
    each agent where agent chose strike { first meadow in spear of agent where meadow.deer is yes { add agent to meadow.hunters } }
  }
  phase fall {
    each meadow where meadow.deer is yes and count(agent in meadow.hunters) >= 2 {
      set meadow.deer = no  add 1 to killed  give 5 to meadow.hunters
    }
  }
  phase flee {  # one who was hit alone drives the deer to another place
    pick 1 meadow as left where left.deer is yes and left.hunters is not nobody {
      pick 1 meadow as new where new.deer is no and nobody on new { set left.deer = no  set new.deer = yes }
    }
  }
  phase rest { each meadow { set meadow.hunters = nobody } }
  checks { conserved count(meadow where meadow.deer is yes) + killed }
  variant fault "a deer that is brought down still leaps up elsewhere" {
    phase flee {
      pick 1 meadow as left where left.hunters is not nobody {
        pick 1 meadow as new where new.deer is no and nobody on new and new.hunters is nobody { set left.deer = no  set new.deer = yes }
      }
    }
  }
}
