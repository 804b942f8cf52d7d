"""The settings of a run: configurations, presets, and the names of policies and of users' code."""
