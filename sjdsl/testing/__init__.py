"""Scenes for tests of games: set up a state as a picture, step both engines, and compare with a second picture."""

from sjdsl.testing.scene import Scene
from sjdsl.testing.stage import Stage

__all__ = ["Scene", "Stage"]
