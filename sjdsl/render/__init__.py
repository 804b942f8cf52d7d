"""Pictures of any compiled game, drawn from its rules and the arrays of a state."""

from typing import TYPE_CHECKING

from sjdsl.lazy_names import lazy_names

if TYPE_CHECKING:
    from sjdsl.render.episode_page import EpisodePage as EpisodePage
    from sjdsl.render.episode_page import make_page as make_page
    from sjdsl.render.film import Painter as Painter
    from sjdsl.render.film import draw_film as draw_film
    from sjdsl.render.film import make_painter as make_painter
    from sjdsl.render.film import save_gif as save_gif
    from sjdsl.render.film import save_mp4 as save_mp4
    from sjdsl.render.film import save_png as save_png
    from sjdsl.render.moment import Moment as Moment
    from sjdsl.render.moment import Snapshot as Snapshot
    from sjdsl.render.moment import take_snapshot as take_snapshot
    from sjdsl.render.playing import play as play
    from sjdsl.render.playing import play_moments as play_moments
    from sjdsl.render.playing import random_policy as random_policy
    from sjdsl.render.playing import stay_policy as stay_policy

__getattr__ = lazy_names(
    __name__,
    {
        "episode_page": ("EpisodePage", "make_page"),
        "film": ("Painter", "draw_film", "make_painter", "save_gif", "save_mp4", "save_png"),
        "moment": ("Moment", "Snapshot", "take_snapshot"),
        "playing": ("play", "play_moments", "random_policy", "stay_policy"),
    },
)
