sj 1
game pond extends "SJ110_extends_itself.sj" { episode 10 }
