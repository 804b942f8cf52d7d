sj 1
# A game has one base, and the variants `socialjax` of games that extend this one need edges.sj.
game endings "When an episode of Melting Pot may end by chance" extends "edges.sj" {  # a base of other games, not a game of its own
  # Melting Pot, StochasticIntervalEpisodeEnding: its count begins at 1 and is asked after the step, so that the first step in which
  # an episode may end is number 1099 with `least` 1000 and `interval` 100, and from there each hundredth
  define may_end(least, interval) = step + 1 >= least and (step + 2) % interval == 0
}
