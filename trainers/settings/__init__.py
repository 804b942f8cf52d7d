"""What a run is told: configurations and their errors, presets, and the names of policies and of users' code."""
