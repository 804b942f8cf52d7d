"""Scenes for tests of games.

A state is set up as a picture, both engines take a step, and the result is compared with a second
picture.
"""

from sjdsl.testing.scene import Scene
from sjdsl.testing.stage import Stage

__all__ = ["Scene", "Stage"]
