"""An episode as plain data for a browser, and as one HTML file that plays it anywhere, without a server and without the internet."""

import html
import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any

import jinja2
import numpy as np
from markupsafe import Markup

from sjdsl.compiler import ir
from sjdsl.files import write_whole
from sjdsl.render.appearance import Drawing, appearance_of, draw_figures
from sjdsl.render.colours import PAPER, hexadecimal
from sjdsl.render.legend import legend_entries
from sjdsl.render.look import Look, make_look
from sjdsl.render.moment import Moment
from sjdsl.render.vector import SIZE, svg_url, vector_figure, vector_tile

FORMAT = 1  # of the data; the page refuses another
DIGITS = 6  # of rewards
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
    # JSON that ends no script element, whatever texts a game has
    text = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    environment = jinja2.Environment(undefined=jinja2.StrictUndefined, autoescape=True, keep_trailing_newline=True)
    page = environment.from_string(_asset("episode.html"))
    script = "\n".join(map(_asset, SCRIPTS))
    return EpisodePage(
        page.render(title=data["title"], style=Markup(_asset("episode.css")), data=Markup(text), script=Markup(script)),  # as they are
    )


def _asset(name: str) -> str:
    return files("sjdsl.render").joinpath(f"page/{name}").read_text(encoding="utf-8")


def episode_data(game: ir.Game, moments: Iterable[Moment]) -> dict[str, Any]:
    """Returns an episode, or several one after the other, as JSON can hold it.

    Keys: `format`; `title`; `height`, `width` of the map in cells, `size` of a picture in pixels;
    `actions`: names by number; `agents`: a colour for each; `marks`: label and colour for each phase that marks; `pictures`: SVG files
    as data URLs; `legend`: [picture, text]; `moments`: see `Artist.moment`.
    """
    artist = Artist(make_look(game))
    told = [artist.moment(moment) for moment in moments]
    if not told:
        raise ValueError("an episode without a moment cannot be shown: give at least its start")
    look = artist.look
    return {
        "format": FORMAT,
        "title": look.title,
        "height": look.height,
        "width": look.width,
        "size": SIZE,
        "actions": list(game.agents.actions),
        "agents": artist.colours,
        "marks": [{"label": label, "colour": hexadecimal(colour)} for label, colour in look.marks],
        "legend": artist.legend(),
        "moments": told,
        "pictures": artist.pictures,
    }


@dataclass
class Artist:
    """Draws moments with as few pictures as possible. pictures: data URLs; colours: of the agents when they were last drawn."""

    look: Look
    pictures: list[str] = field(default_factory=list)
    colours: list[str] = field(default_factory=list)
    _numbers: dict[str, int] = field(default_factory=dict)
    _last: np.ndarray | None = None

    def moment(self, moment: Moment) -> dict[str, Any]:
        """Returns one moment.

        Keys: `step`; `cells`: [cell, picture, cell, picture, …], of all cells in the first moment and then of those that look otherwise
        than in the moment before, numbered in reading order; `figures`: [picture, row, column] of agents and then movers that are on the
        map; `marks`: the marked cells of each phase; `actions`: a number for each agent, or nothing at the start of an episode;
        `rewards`, `returns` of each agent; `events`: [name, count of each agent, or one count]; `done`.
        """
        shot = moment.snapshot
        seen = appearance_of(self.look, shot)
        numbers = np.array([self.picture_of(vector_tile(drawing)) for drawing in seen.drawings])
        cells = numbers[seen.cells].reshape(-1)
        changed = np.arange(cells.size) if self._last is None else np.flatnonzero(cells != self._last)
        self._last = cells
        self.colours = [hexadecimal(figure.colour) for figure in draw_figures(self.look, shot)["agent"]]
        return {
            "step": shot.step,
            "cells": np.stack([changed, cells[changed]], axis=1).reshape(-1).tolist(),
            "figures": [[self.picture_of(vector_figure(figure)), row, col] for figure, row, col in seen.figures],
            "marks": [np.flatnonzero(marked).tolist() for _, marked in seen.marks],
            "actions": list(moment.actions),
            "rewards": _rounded(moment.reward),
            "returns": _rounded(shot.returns),
            "events": [[name, np.asarray(count).tolist()] for name, count in moment.events.items()],
            "done": moment.done,
        }

    def legend(self) -> list[list[Any]]:
        """Returns what can be seen on the board: [picture, text]."""
        svgs = (
            (vector_tile(seen) if isinstance(seen, Drawing) else vector_figure(seen, PAPER), text)
            for seen, text in legend_entries(self.look)
        )
        return [[self.picture_of(svg), text] for svg, text in svgs]

    def picture_of(self, svg: str) -> int:
        """Returns the number of a picture; equal ones have one number."""
        if svg not in self._numbers:
            self._numbers[svg] = len(self.pictures)
            self.pictures.append(svg_url(svg))
        return self._numbers[svg]


def _rounded(values: np.ndarray) -> list[float]:
    return [round(float(value), DIGITS) for value in values]
