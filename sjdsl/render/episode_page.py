"""An episode as data for a browser, and as one HTML file that plays it.

The file needs no server and no internet.
"""

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
from sjdsl.render.appearance import Drawing, Figure, appearance_of, draw_figures, possessions_of
from sjdsl.render.colours import PAPER, hexadecimal
from sjdsl.render.legend import legend_entries
from sjdsl.render.look import Look, make_look
from sjdsl.render.moment import Moment, Snapshot
from sjdsl.render.vector import SIZE, svg_url, vector_figure, vector_tile

FORMAT = 1  # of the data; the page refuses another
DIGITS = 6  # after the point, of rewards
SCRIPTS = ("board.js", "plot.js", "episode.js")
SPEED = 8.0  # moments a second
FRAME_HEIGHT = 720  # pixels of the frame in a notebook


@dataclass(frozen=True)
class EpisodePage:
    """A page; a notebook shows it where it is the value of a cell. text: the whole file."""

    text: str

    def save(self, path: Path | str) -> None:
        """Writes the file, as UTF-8, whole or not at all."""
        write_whole(Path(path), self.text)

    def _repr_html_(self) -> str:
        """Returns the page in a frame whose scripts can't reach anything around it."""
        style = f"width: 100%; height: {FRAME_HEIGHT}px; border: 0"
        return (
            f'<iframe sandbox="allow-scripts" style="{style}" srcdoc="{html.escape(self.text)}">'
            "</iframe>"
        )


def make_page(
    game: ir.Game,
    moments: Iterable[Moment],
    speed: float = SPEED,
    players: Sequence[str] = (),
    seed: int | None = None,
) -> EpisodePage:
    """Returns the page of an episode, or of several one after the other.

    Args:
      game: the rules, `env.game`.
      moments: from `play_moments`, from `sjdsl.replay.replayed`, or built by hand; at least one.
      speed: moments a second, until the viewer chooses another speed.
      players: who plays each agent, by the names of policies; the page names them, and the seed.
      seed: of the episode.

    Raises:
      ValueError: there is no moment.
    """
    told = {"speed": speed, "players": list(players), "seed": seed}
    data = {**episode_data(game, moments), **told}
    # `<` is escaped so that no text of a game ends the script element.
    text = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    environment = jinja2.Environment(
        undefined=jinja2.StrictUndefined, autoescape=True, keep_trailing_newline=True
    )
    page = environment.from_string(_asset("episode.html")).render(
        title=data["title"],
        style=Markup(_asset("episode.css")),
        data=Markup(text),
        script=Markup("\n".join(map(_asset, SCRIPTS))),
    )
    return EpisodePage(page)


def _asset(name: str) -> str:
    """Returns a file of the page: its template, its style or a script."""
    return files("sjdsl.render").joinpath(f"page/{name}").read_text(encoding="utf-8")


def episode_data(game: ir.Game, moments: Iterable[Moment]) -> dict[str, Any]:
    """Returns an episode, or several one after the other, as data for JSON.

    Keys: `format`; `title`; `height`, `width` of the map in cells, `size` of a picture in pixels;
    `actions`: names by number; `agents`: a colour for each; `has`: whether there is a column of
    what agents have; `pictures`: SVG files as data URLs; `legend`: [picture, text] of what is in
    some moment; `moments`: see `Artist.moment`. A picture is an index into `pictures`.
    """
    look = make_look(game)
    artist = Artist(look)
    moments = list(moments)
    if not moments:
        raise ValueError("an episode without a moment cannot be shown: give at least its start")
    drawn = [artist.moment(moment) for moment in moments]
    return {
        "format": FORMAT,
        "title": look.title,
        "height": look.height,
        "width": look.width,
        "size": SIZE,
        "actions": list(game.agents.actions),
        "agents": artist.colours,
        "has": bool(look.possessions or look.own),
        "legend": artist.legend([moment.snapshot for moment in moments]),
        "moments": drawn,
        "pictures": artist.pictures,
    }


@dataclass
class Artist:
    """Draws moments with as few pictures as possible.

    pictures: data URLs; colours: of the agents in the moment drawn last, as are _cells, each cell's
    picture, and _before, its state.
    """

    look: Look
    pictures: list[str] = field(default_factory=list)
    colours: list[str] = field(default_factory=list)
    _numbers: dict[str, int] = field(default_factory=dict)
    _cells: np.ndarray | None = None
    _before: Snapshot | None = None

    def moment(self, moment: Moment) -> dict[str, Any]:
        """Returns one moment as data for JSON.

        Keys:
          `step`; `done`; `rewards` and `returns` of each agent;
          `cells`: [cell, picture, cell, picture, …] with cells numbered in reading order: all in
            the first moment, then those that differ from the moment before;
          `figures`: [picture, row, column] in the order of drawing;
          `actions`: a number for each agent, or nothing at the start of an episode;
          `held`: for each agent, [field, picture, amount] of each thing that it has;
          `own`: for each agent, [name, value] of what else it observes of itself;
          `world`: [name, value] of what agents observe of the world;
          `events`: [name, count of each agent or one count];
          `why`: what each agent gave as its reason, if agents were asked;
          `away`: the agents that are not on the map.
        """
        look = self.look
        snapshot = moment.snapshot
        appearance = appearance_of(look, snapshot, moment.actions, self._before)
        pictures = [self.picture_of(vector_tile(drawing)) for drawing in appearance.drawings]
        cells = np.array(pictures)[appearance.cells].reshape(-1)
        changed = np.arange(cells.size)
        if self._cells is not None:
            changed = np.flatnonzero(cells != self._cells)
        self._before = snapshot
        self._cells = cells
        self.colours = [
            hexadecimal(figure.colour) for figure in draw_figures(look, snapshot)["agent"]
        ]
        agents = range(look.num_agents)
        return {
            "step": snapshot.step,
            "cells": np.stack([changed, cells[changed]], axis=1).reshape(-1).tolist(),
            "figures": [
                [self.picture_of(vector_figure(figure)), row, col]
                for figure, row, col in appearance.figures
            ],
            "actions": list(moment.actions),
            "rewards": _rounded(moment.reward),
            "returns": _rounded(snapshot.returns),
            "held": [self._possessions(snapshot, agent) for agent in agents],
            "own": [
                [[reading.name, reading.text(snapshot, agent)] for reading in look.own]
                for agent in agents
            ],
            "world": [[reading.name, reading.text(snapshot)] for reading in look.world],
            "events": [[name, np.asarray(count).tolist()] for name, count in moment.events.items()],
            "why": list(moment.why),
            "away": np.flatnonzero(snapshot.row < 0).tolist(),
            "done": moment.done,
        }

    def _possessions(self, snapshot: Snapshot, agent: int) -> list[list[Any]]:
        """Returns [field, picture, amount] of each thing that an agent has."""
        names = [field.name for field in self.look.possessions for _ in field.words]
        entries: list[list[Any]] = []
        things = possessions_of(self.look, snapshot, agent)
        for name, (thing, amount) in zip(names, things, strict=True):
            if amount:
                figure = Figure(None, thing.colour, thing.sprite)
                entries.append([name, self.picture_of(vector_figure(figure)), amount])
        return entries

    def legend(self, shown: Sequence[Snapshot] | None = None) -> list[list[Any]]:
        """Returns [picture, text] of what can be seen, in the moments `shown` or at all."""
        entries: list[list[Any]] = []
        for symbol, text in legend_entries(self.look, shown):
            if isinstance(symbol, Drawing):
                svg = vector_tile(symbol)
            else:
                svg = vector_figure(symbol, PAPER)
            entries.append([self.picture_of(svg), text])
        return entries

    def picture_of(self, svg: str) -> int:
        """Returns the index of a picture in `pictures`; equal ones have one index."""
        if svg not in self._numbers:
            self._numbers[svg] = len(self.pictures)
            self.pictures.append(svg_url(svg))
        return self._numbers[svg]


def _rounded(values: np.ndarray) -> list[float]:
    return [round(float(value), DIGITS) for value in values]
