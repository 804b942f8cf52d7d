"""An episode on the screen of a terminal: the map in letters and colours, the agents, their rewards, a legend, and keys that steer."""
