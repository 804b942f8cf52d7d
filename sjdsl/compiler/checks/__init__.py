"""Checks of the whole typed game: write conflicts, placement of agents, timers, unused names."""
