"""Scenes of a game as pictures: put one, take a step on the compiled game and on the interpreter, say what must have become of it."""

from sjdsl.testing.scene import Scene
from sjdsl.testing.stage import Stage

__all__ = ["Scene", "Stage"]
