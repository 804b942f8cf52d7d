sj 1
game pond extends "lake.sj" { episode 10 }
