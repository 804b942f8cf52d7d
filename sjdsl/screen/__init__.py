"""An episode in the terminal: the map in letters and colours, agents, rewards, a legend, and keys that control an agent."""

COMPILING = "sjdsl-compiling"  # the name of the thread in which a game is compiled while it is played
