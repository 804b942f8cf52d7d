"""Writes an episode as one HTML file that plays it in any browser, without a server and without the internet."""

import html
import json
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

import jinja2
from markupsafe import Markup

from sjdsl.compiler import ir
from sjdsl.files import write_whole
from sjdsl.render.episode_data import episode_data
from sjdsl.render.moment import Moment

SCRIPTS = ("board.js", "plot.js", "episode.js")
SPEED = 8.0
FRAME_HEIGHT = 720  # pixels of the frame in a notebook


@dataclass(frozen=True)
class EpisodePage:
    """A page. text: the whole file; in a notebook it is shown where it is the value of a cell."""

    text: str

    def save(self, path: Path | str) -> None:
        """Writes the file, as UTF-8, whole or not at all."""
        write_whole(Path(path), self.text)

    def _repr_html_(self) -> str:
        """Returns the page in a frame of its own, which can run its scripts and reach nothing around it."""
        return f'<iframe sandbox="allow-scripts" style="width: 100%; height: {FRAME_HEIGHT}px; border: 0" srcdoc="{html.escape(self.text)}"></iframe>'


def make_page(game: ir.Game, moments: Iterable[Moment], speed: float = SPEED) -> EpisodePage:
    """Returns the page of an episode, or of several one after the other.

    Args:
      game: the rules, `env.game`.
      moments: of `play_moments`, of `sjdsl.replay.replayed`, or made by hand; at least one.
      speed: moments a second, until somebody chooses another speed.

    Raises:
      ValueError: there is no moment.
    """
    data = {**episode_data(game, moments), "speed": speed}
    environment = jinja2.Environment(undefined=jinja2.StrictUndefined, autoescape=True, keep_trailing_newline=True)
    page = environment.from_string(_asset("episode.html"))
    as_is = Markup  # our own files, and data in which no `<` is left
    return EpisodePage(
        page.render(
            title=data["title"],
            style=as_is(_asset("episode.css")),
            data=as_is(_json(data)),
            script=as_is("\n".join(_asset(name) for name in SCRIPTS)),
        )
    )


def _json(data: object) -> str:
    """Returns JSON that ends no script element, whatever texts a game has."""
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _asset(name: str) -> str:
    return files("sjdsl.render").joinpath(f"page/{name}").read_text(encoding="utf-8")
