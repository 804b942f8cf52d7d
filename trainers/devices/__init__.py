"""The devices and processes that a run spreads over."""
