sj 1
game chemistry "Chemistry" {
  about summary "Molecules side by side react. Rings make food of energy; energy comes of the waste of two rings, brought together."
  cite "Agapiou et al. 2022, Melting Pot 2"  size players : count = 8 in 1 .. 40  episode 1000  # Melting Pot
  param ground  : probability = { background: 0.00001, low: 0.005, medium: 0.001, high: 0.9 }   # Melting Pot: to react, per step
  param carried : probability = { background: 0, low: 0.0025, medium: 0.25, high: 0.9 }         # Melting Pot
  kind dish "~" {
    field mol  : { empty, xa, xb, xc, ya, yb, yc, za, zb, zc, x, y, ix, iy, food1, food2, food3, energy, lure, hot } = empty
    field next : { none, empty, xa, xb, xc, ya, yb, yc, za, zb, zc, x, y, ix, iy, food1, food2, food3, energy, lure, hot } = none
    field held : { none, empty, xa, xb, xc, ya, yb, yc, za, zb, zc, x, y, ix, iy, food1, food2, food3, energy, lure, hot } = none
    field plan : { idle, x1, x2, x3, y1, y2, y3, z1, z2, z3, cx, cy, xy, px, py } = idle
    field site : { idle, x1, x2, x3, y1, y2, y3, z1, z2, z3, cx, cy, xy, px, py } = idle
    field rank : 0 .. 9 = 0  field held_rank : 0 .. 10 = 0  field ticket : 0 .. 60000 = 0  field top : 0 .. 60000 = 0
    field lit : { no, yes } = no  field spark : { no, yes } = no  timer fresh  glyph "x" with mol = lure
    glyph "a" with mol = xa  glyph "b" with mol = xb  glyph "c" with mol = xc  glyph "1" with mol = ya  glyph "2" with mol = yb
    glyph "3" with mol = yc  glyph "4" with mol = za  glyph "5" with mol = zb  glyph "6" with mol = zc  glyph "h" with mol = energy
  }
  agents players {
    acts turn_left, turn_right, step_left, step_right, forward, backward, stay, exchange  moves relative
    field mol  : { empty, xa, xb, xc, ya, yb, yc, za, zb, zc, x, y, ix, iy, food1, food2, food3, energy, lure, hot } = empty
    field next : { none, empty, xa, xb, xc, ya, yb, yc, za, zb, zc, x, y, ix, iy, food1, food2, food3, energy, lure, hot } = none
    field due : reward  timer fresh  timer cooling  forbid all when agent.mol is hot  forbid exchange when agent.cooling > 0
  }
  param takes1  : word = {  # Melting Pot: what a reaction takes; of the third, x3, y3, z3, px and py take two
    idle: none, x1: xa, x2: xb, x3: xc, y1: ya, y2: yb, y3: yc, z1: za, z2: zb, z3: zc, cx: x, cy: y, xy: x, px: ix, py: iy }
  param takes2  : word = {  # Melting Pot
    idle: none, x1: xb, x2: xc, x3: xa, y1: yb, y2: yc, y3: ya, z1: zb, z2: zc, z3: za, cx: ix, cy: iy, xy: y, px: ix, py: iy }
  param takes3  : word = {
    idle: none, x1: empty, x2: energy, x3: empty, y1: empty, y2: energy, y3: empty, z1: empty, z2: energy, z3: empty,
    cx: none, cy: none, xy: none, px: ix, py: iy }  # Melting Pot
  param leaves  : word = {
    x1: food1, x2: energy, x3: x, y1: food2, y2: energy, y3: y, z1: food3, z3: food1, xy: energy,
    idle: empty, z2: empty, cx: empty, cy: empty, px: empty, py: empty }  # Melting Pot: in the place of the first that is of no ring
  param likes   : word = {
    xa: x1, xb: x2, xc: x3, ya: y1, yb: y2, yc: y3, za: z1, zb: z2, zc: z3, x: xy, y: xy, ix: px, iy: py,
    none: idle, empty: idle, food1: idle, food2: idle, food3: idle, energy: idle, lure: idle, hot: idle }  # Melting Pot
  param or_else : word = {
    xa: x3, xb: x1, xc: x2, ya: y3, yb: y1, yc: y2, za: z3, zb: z1, zc: z2, x: cx, y: cy, ix: cx, iy: cy,
    none: idle, empty: idle, food1: idle, food2: idle, food3: idle, energy: idle, lure: idle, hot: idle }  # Melting Pot
  param turned  : word = {  # Melting Pot: within its ring
    xa: xb, xb: xc, xc: xa, ya: yb, yb: yc, yc: ya, za: zb, zb: zc, zc: za, empty: none, x: none, y: none,
    ix: none, iy: none, food1: none, food2: none, food3: none, energy: none, lure: none, hot: none }
  define class(m)           = case m {
    empty: background, energy: low, x: medium, y: medium, food1: medium, food2: medium, food3: medium, lure: medium, otherwise: high }
  define product(r, m, n)   = case turned[m] is none { no: turned[m], yes: case n { 0: leaves[r], otherwise: later(r) } }
  define some_left(r, m, n) = n == 0 or n == 1 and r in { x3, y3, z3, px, py } and m is takes3[r]
  define uses(r, m) = m is takes1[r] or m is takes2[r] or m is takes3[r]  phase start { each agent { send agent to dish } }
  define near(s, m) = sum(case d.mol is m { yes: 1, no: 0 } + case d.held is m { yes: 1, no: 0 } over dish as d in disc(1, centre) of s)
  define room(s, m, n) = m is none or near(s, m) > n  define later(r) = case r { x3: iy, y3: ix, z3: food2, otherwise: empty }
  define can(s, r, m, n) = near(s, case m is takes1[r] { yes: takes2[r], no: takes1[r] }) > 0 and room(s, takes3[r], n)
  define weight(s) = case s.plan in { cx, cy, xy, px, py } { yes: s.ticket + 60000, no: s.ticket }  map "maps/chemistry_three.txt"
  define best(s) = max(weight(d) over dish as d in diamond(2) of s where d.plan is not idle otherwise 0)
  schedule light -> choose_one -> settle -> spread -> react -> digest -> swap -> turn -> walk -> tick  phase walk { move each agent }
  phase light {
    each dish { draw n from 1 .. 60000  set dish.ticket = n }
    each dish as d where d.fresh <= 1 { chance ground[class(d.mol)] { set d.lit = yes  tally lit[class(d.mol)] } }
    each agent as v on dish as d { set d.held = v.mol  when v.fresh <= 1 { chance carried[class(v.mol)] { set d.spark = yes } } }
  }
  phase choose_one {  # what is carried begins its reaction rather than what lies under it
    each dish as d where d.lit is yes or d.spark is yes {
      draw coin from 0 .. 1  let m = case d.spark is yes and likes[d.held] is not idle { yes: d.held, no: d.mol }
      let this = likes[m]  let this_can = can(d, this, m, case m { xc: 1, yc: 1, zc: 1, ix: 1, iy: 1, otherwise: 0 })
      let that = or_else[m]  let that_can = can(d, that, m, case m { xa: 1, ya: 1, za: 1, otherwise: 0 })
      when this_can and (coin == 0 or not that_can) { set d.plan = this } otherwise when that_can { set d.plan = that }
    }
    each dish as u { set u.top = max(d.ticket over dish as d in disc(1, centre) of u where d.mol is u.held otherwise 0) }
  }
  phase settle { each dish as s where s.plan is not idle and best(s) > weight(s) { set s.plan = idle } }
  phase spread {  # Melting Pot: molecules on the ground come before those that are carried
    each dish as p {
      pick 1 dish as s in disc(1, centre) of p where s.plan is not idle {
        set p.site = s.plan  set p.rank = count(dish as d in disc(1, centre) of s where d.mol is p.mol and d.ticket > p.ticket)
        let carried_before = count(dish as d in disc(1, centre) of s where d.held is p.held and d.ticket > p.ticket)
        set p.held_rank = count(dish as d in disc(1, centre) of s where d.mol is p.held) + carried_before
      }
    }
  }
  phase react {
    each dish as p where uses(p.site, p.mol) and some_left(p.site, p.mol, p.rank) { set p.next = product(p.site, p.mol, p.rank) }
    each agent as v on dish as p where uses(p.site, v.mol) and some_left(p.site, v.mol, p.held_rank) {
      set v.next = product(p.site, v.mol, p.held_rank)  set v.due = case p.site { xy: 10, otherwise: 0 }
    }
  }
  phase digest {  # Melting Pot: food that lies beside food that is carried is digested in its place, and pays nobody
    each dish as p where p.next is none and p.mol in { empty, food1, food2, food3, energy } {
      draw new from { food1, food2 }
      let eaten = count(dish as u in disc(1, centre) of p where u.spark is yes and u.top == p.ticket and u.held is p.mol) > 0
      when p.mol is empty { when p.lit is yes { set p.next = new } } otherwise when p.lit is yes or eaten { set p.next = empty }
    }
    each agent as v on dish as u where v.next is none and u.spark is yes and u.top == 0 and v.mol in { food1, food2, food3, energy, lure } {
      set v.next = case v.mol { lure: lure, otherwise: empty }  set v.due = case v.mol { food3: 10, lure: 0.1, energy: 0, otherwise: 1 }
    }
  }
  phase swap {
    each agent as v on dish as d where v chose exchange and v.next is none and d.next is none and d.mol is not hot and d.fresh == 0 {
      set v.mol = d.mol  set d.mol = v.mol  set v.fresh = 3  set d.fresh = 3
    }
    each agent where agent chose exchange { set agent.cooling = 3 }  # Melting Pot: two steps of pause
  }
  phase turn {  # a step as a hot molecule, then the new one
    each dish { set dish.plan = idle  set dish.site = idle  set dish.held = none  set dish.lit = no  set dish.spark = no }
    each dish as d where d.next is not none {
      when d.mol is hot { set d.mol = d.next  set d.next = none  set d.fresh = 3 } otherwise { set d.mol = hot }
    }
    each agent as v where v.mol is hot and v.next is not none { set v.mol = v.next  set v.next = none  set v.fresh = 3  give v.due to v }
    each agent as v where v.mol is not hot and v.next is not none { set v.mol = hot }
  }
  look dish where dish.mol is xa as sky cube  look dish where dish.mol is xb as blue cube  look dish where dish.mol is xc as purple cube
  look dish where dish.mol is ya as yellow mushroom  look dish where dish.mol is yb as orange mushroom
  look dish where dish.mol is yc as red mushroom  look dish where dish.mol is za as white coin
  look dish where dish.mol is zb as green coin  look dish where dish.mol is zc as black coin
  look dish where dish.mol is x as blue ore  look dish where dish.mol is y as red ore
  look dish where dish.mol is ix as sky gem  look dish where dish.mol is iy as pink gem
  look dish where dish.mol is food1 as red apple  look dish where dish.mol is food2 as green apple
  look dish where dish.mol is food3 as brown apple  look dish where dish.mol is energy as yellow gem
  look dish where dish.mol is lure as banana  look dish where dish.mol is hot as orange
  observe { show agent.mol  show other.mol  hide dish.next  hide dish.held  hide dish.plan  hide dish.site  hide dish.lit  hide dish.spark }
  metrics { event lit by { background, low, medium, high }  mean energy_left = count(dish where dish.mol is energy) }
  checks { symmetric agents  always count(dish as d where d.plan is not idle or d.site is not idle or d.lit is yes or d.spark is yes) == 0 }
  checks hot { always count(dish as d where d.mol is not hot and d.next is not none) == 0 }
  define joins(a, m) = a.mol is empty and m is x or a.mol is x and m is y
  define above(a, m) = a.mol is empty and count(agent as b on dish as d where b is a and d.mol is m) > 0
  define fed(a)      = above(a, food1) or above(a, food2) or above(a, food3)
  policy cooperator "carries one waste to the other" { when above(agent, x) choose exchange  seek dish where joins(agent, dish.mol) }
  policy defector "eats" { when fed(agent) choose exchange  seek dish where agent.mol is empty and dish.mol in { food1, food2, food3 } }
  variant two "two rings" { map "maps/chemistry_two.txt" }
  variant two_distractors "two rings, and molecules that pay a little to who carries them" { map "maps/chemistry_two_distractors.txt" }
  variant distractors "three rings, and many molecules that pay a little to who carries them" { map "maps/chemistry_three_distractors.txt" }
}
