"""Pictures of any compiled game, from its rules and the arrays of a state alone."""

from sjdsl.render.film import save_gif, save_mp4, save_png
from sjdsl.render.frame import Painter, make_painter
from sjdsl.render.play import play, random_policy, stay_policy
from sjdsl.render.snapshot import Snapshot, take_snapshot

__all__ = [
    "Painter",
    "Snapshot",
    "make_painter",
    "play",
    "random_policy",
    "save_gif",
    "save_mp4",
    "save_png",
    "stay_policy",
    "take_snapshot",
]
