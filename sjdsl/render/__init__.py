"""Pictures of any compiled game, drawn from its rules and the arrays of a state."""

from typing import TYPE_CHECKING

from sjdsl.lazy_names import lazy_names

if TYPE_CHECKING:
    from sjdsl.render.episode_page import EpisodePage, make_page
    from sjdsl.render.film import Painter, draw_film, make_painter, save_gif, save_mp4, save_png
    from sjdsl.render.moment import Moment, Snapshot, take_snapshot
    from sjdsl.render.playing import one_of, play, play_moments, random_policy, stay_policy

__all__ = [
    "EpisodePage",
    "Moment",
    "Painter",
    "Snapshot",
    "draw_film",
    "make_page",
    "make_painter",
    "one_of",
    "play",
    "play_moments",
    "random_policy",
    "save_gif",
    "save_mp4",
    "save_png",
    "stay_policy",
    "take_snapshot",
]

__getattr__ = lazy_names(
    __name__,
    {
        "EpisodePage": "episode_page",
        "Moment": "moment",
        "Painter": "film",
        "Snapshot": "moment",
        "draw_film": "film",
        "make_page": "episode_page",
        "make_painter": "film",
        "one_of": "playing",
        "play": "playing",
        "play_moments": "playing",
        "random_policy": "playing",
        "save_gif": "film",
        "save_mp4": "film",
        "save_png": "film",
        "stay_policy": "playing",
        "take_snapshot": "moment",
    },
)
