"""An episode on the screen of a terminal: the map in letters and colours, the agents, their rewards, a legend, and keys that steer."""

COMPILING = "sjdsl-compiling"  # the name of the thread in which a game is compiled while it is played
