sj 1
game edges "What beams reach past the edges in the released code of SocialJax" {  # a base of other games, not a game of its own
  # Released code: its grid is read up to `reach` cells ahead of an agent without a look at the edges. An index below 0 counts from the end,
  # so the beam goes on at the opposite edge. One past the end is read as the last, so who faces that edge hits itself.
  define past_top(a, x, reach, rows)        = a.heading is north and x.col == a.col and x.row >= a.row + rows - reach
  define past_left(a, x, reach, cols)       = a.heading is west and x.row == a.row and x.col >= a.col + cols - reach
  define past_edge(a, x, reach, rows, cols) = past_top(a, x, reach, rows) or past_left(a, x, reach, cols)
  define hits_itself(a, rows, cols)         = a.heading is south and a.row == rows - 1 or a.heading is east and a.col == cols - 1

  # Released code: the cells of all agents' beams, fired or not, are written one after another: first all that are one ahead, then two
  # ahead, to the left and to the right of that; of a sort, in the order of the agents.
  define ahead(a, x)  = case a.heading { north: a.row - x.row, east: x.col - a.col, south: x.row - a.row, west: a.col - x.col }
  define aright(a, x) = case a.heading { north: x.col - a.col, east: x.row - a.row, south: a.col - x.col, west: a.row - x.row }
  define laid(a, x)   = case ahead(a, x) {
    1: case 1 + aright(a, x) { 0: 3, 1: 1, 2: 4, otherwise: 0 }, 2: case aright(a, x) { 0: 2, otherwise: 0 }, otherwise: 0
  }
}
