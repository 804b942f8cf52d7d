"""An episode as plain data for a browser, and as one HTML file that plays it anywhere, without a server and without the internet."""

import html
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path
from typing import Any

import jinja2
import numpy as np
from markupsafe import Markup

from sjdsl.compiler import ir
from sjdsl.files import write_whole
from sjdsl.render.appearance import Drawing, Figure, appearance_of, draw_figures, held_entries
from sjdsl.render.colours import PAPER, hexadecimal
from sjdsl.render.legend import legend_entries
from sjdsl.render.look import Look, make_look
from sjdsl.render.moment import Moment, Snapshot
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
    environment = jinja2.Environment(
        undefined=jinja2.StrictUndefined, autoescape=True, keep_trailing_newline=True
    )
    page = environment.from_string(_asset("episode.html"))
    script = "\n".join(map(_asset, SCRIPTS))
    return EpisodePage(
        page.render(
            title=data["title"],
            style=Markup(_asset("episode.css")),
            data=Markup(text),
            script=Markup(script),
        ),  # as they are
    )


def _asset(name: str) -> str:
    return files("sjdsl.render").joinpath(f"page/{name}").read_text(encoding="utf-8")


def episode_data(game: ir.Game, moments: Iterable[Moment]) -> dict[str, Any]:
    """Returns an episode, or several one after the other, as JSON can hold it.

    Keys: `format`; `title`; `height`, `width` of the map in cells, `size` of a picture in pixels;
    `actions`: names by number; `agents`: a colour for each; `has`: whether something stands in the column of what agents have;
    `pictures`: SVG files as data URLs; `legend`: [picture, text] of what is in some moment; `moments`: see `Artist.moment`.
    """
    artist, shown = Artist(make_look(game)), []
    told = []
    for moment in moments:
        shown.append(moment.snapshot)
        told.append(artist.moment(moment))
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
        "has": bool(look.held or look.own),
        "legend": artist.legend(shown),
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
    _before: Snapshot | None = None

    def moment(self, moment: Moment) -> dict[str, Any]:
        """Returns one moment.

        Keys: `step`; `cells`: [cell, picture, cell, picture, …], of all cells in the first moment and then of those that look otherwise
        than in the moment before, numbered in reading order; `figures`: [picture, row, column] of beams, flashes, agents and movers, each
        over those before; `actions`: a number for each agent, or nothing at the start of an episode; `rewards`, `returns` of each agent;
        `held`: [row, picture, amount] of what each agent has; `own`: [name, value] of what else it is shown of itself, `world`: of the world;
        `events`: [name, count of each agent, or one count]; `done`.
        """
        shot = moment.snapshot
        seen = appearance_of(self.look, shot, moment.actions, self._before)
        self._before = shot
        numbers = np.array([self.picture_of(vector_tile(drawing)) for drawing in seen.drawings])
        cells = numbers[seen.cells].reshape(-1)
        changed = (
            np.arange(cells.size) if self._last is None else np.flatnonzero(cells != self._last)
        )
        self._last = cells
        self.colours = [
            hexadecimal(figure.colour) for figure in draw_figures(self.look, shot)["agent"]
        ]
        return {
            "step": shot.step,
            "cells": np.stack([changed, cells[changed]], axis=1).reshape(-1).tolist(),
            "figures": [
                [self.picture_of(vector_figure(figure)), row, col]
                for figure, row, col in seen.figures
            ],
            "actions": list(moment.actions),
            "rewards": _rounded(moment.reward),
            "returns": _rounded(shot.returns),
            "held": [self._held(shot, agent) for agent in range(self.look.num_agents)],
            "own": [
                [[r.name, r.text(shot, agent)] for r in self.look.own]
                for agent in range(self.look.num_agents)
            ],
            "world": [[reading.name, reading.text(shot)] for reading in self.look.world],
            "events": [[name, np.asarray(count).tolist()] for name, count in moment.events.items()],
            "done": moment.done,
        }

    def _held(self, snapshot: Snapshot, agent: int) -> list[list[Any]]:
        names = [row.name for row in self.look.held for _ in row.words]
        things = zip(names, held_entries(self.look, snapshot, agent), strict=True)
        figures = [
            (name, Figure(None, thing.colour, thing.sprite), amount)
            for name, (thing, amount) in things
            if amount
        ]
        return [
            [name, self.picture_of(vector_figure(figure)), amount]
            for name, figure, amount in figures
        ]

    def legend(self, shown: Sequence[Snapshot] | None = None) -> list[list[Any]]:
        """Returns what can be seen on the board, or is in one of the moments that are shown: [picture, text]."""
        entries = legend_entries(self.look, shown)
        return [
            [
                self.picture_of(
                    vector_tile(seen) if isinstance(seen, Drawing) else vector_figure(seen, PAPER)
                ),
                text,
            ]
            for seen, text in entries
        ]

    def picture_of(self, svg: str) -> int:
        """Returns the number of a picture; equal ones have one number."""
        if svg not in self._numbers:
            self._numbers[svg] = len(self.pictures)
            self.pictures.append(svg_url(svg))
        return self._numbers[svg]


def _rounded(values: np.ndarray) -> list[float]:
    return [round(float(value), DIGITS) for value in values]
