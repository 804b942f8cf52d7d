sj 1
game paintball_king_of_the_hill "Paintball: King of the Hill" extends "paintball.sj" {
  about summary "Two teams paint the ground and each other. A team that has painted four fifths of the hill holds it until it has less than"
                "half of it, and is paid for that in each step, at the cost of the other team."
  param enough  : count = 80 in 51 .. 100           # Melting Pot: of a hundred squares of the hill, to hold it
  param too_few : count = 50 in 1 .. 100            # Melting Pot: with less it is lost
  map "maps/paintball_king_of_the_hill.txt"
  field control : { neither, red, blue } = neither  # who holds the hill
  define held(hue)  = count(ground where ground.site is hill and ground.paint is hue)
  define squares    = count(ground where ground.site is hill)
  define takes(hue) = control is not hue and squares > 0 and 100 * held(hue) >= enough * squares
  define loses(hue) = control is hue and 100 * held(hue) < too_few * squares
  schedule tick -> walk -> fire -> settle -> fall -> heal -> seize -> pay
  define holder = case loses(red) or loses(blue) { yes: neither, no: control }
  phase seize {
    set control = case takes(red) { yes: red, no: case takes(blue) { yes: blue, no: holder } }
    when takes(red) or takes(blue) { tally seized }
    each ground where ground.site is hill {
      when takes(red) { set ground.paint = red } otherwise when takes(blue) { set ground.paint = blue }
    }
  }
  phase pay {
    when control is red { give -1 * score to all  give 2 * score to reds }
    otherwise when control is blue { give score to all  give -2 * score to reds }
  }
  observe {
    hide agent.load  hide other.load
    show ground.site as { hill where ground.site is hill, plain }
  }
  metrics { event seized }
  drop lost  drop safe  drop carry  drop restore  drop signal  drop taken  drop returned  drop captured  # no flags
}
