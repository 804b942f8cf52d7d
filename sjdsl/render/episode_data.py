"""An episode as plain data for a page in a browser: pictures once, and for each moment which of them stand where."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.render.colours import PAPER, Colour, mixed
from sjdsl.render.drawings import Drawing, Figure, cell_keys, draw_cell, draw_figures, draw_movers
from sjdsl.render.entries import cell_entries, figure_entries
from sjdsl.render.look import Look, make_look
from sjdsl.render.moment import Moment
from sjdsl.render.snapshot import Snapshot
from sjdsl.render.vector import SIZE, svg_url, vector_figure, vector_tile

FORMAT = 1  # of the data; the page refuses another
DIGITS = 6  # of rewards
MARKED = 0.6  # how much of a marked cell has the colour of its mark, in the legend


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
        "marks": [{"label": label, "colour": _css(colour)} for label, colour in look.marks],
        "legend": [[artist.picture_of(picture), text] for picture, text in _legend(look)],
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
    _tiles: dict[tuple[str, tuple[int, ...]], int] = field(default_factory=dict)
    _bodies: dict[Figure, int] = field(default_factory=dict)
    _last: np.ndarray | None = None

    def moment(self, moment: Moment) -> dict[str, Any]:
        """Returns one moment.

        Keys: `step`; `cells`: [cell, picture, cell, picture, …], of all cells in the first moment and then of those that look otherwise
        than in the moment before, numbered in reading order; `figures`: [picture, row, column] of agents and then movers that are on the
        map; `marks`: the marked cells of each phase; `actions`: a number for each agent, or nothing at the start of an episode;
        `rewards`, `returns` of each agent; `events`: [name, count of each agent, or one count]; `done`.
        """
        shot = moment.snapshot
        cells = self._cells(shot)
        changed = np.arange(cells.size) if self._last is None else np.flatnonzero(cells != self._last)
        self._last = cells
        return {
            "step": shot.step,
            "cells": np.stack([changed, cells[changed]], axis=1).reshape(-1).tolist(),
            "figures": list(self._figures(shot)),
            "marks": [np.flatnonzero(shot.marks[label]).tolist() for label, _ in self.look.marks],
            "actions": list(moment.actions),
            "rewards": _rounded(moment.reward),
            "returns": _rounded(shot.returns),
            "events": [[name, np.asarray(count).tolist()] for name, count in moment.events.items()],
            "done": moment.done,
        }

    def picture_of(self, svg: str) -> int:
        """Returns the number of a picture; equal ones have one number."""
        if svg not in self._numbers:
            self._numbers[svg] = len(self.pictures)
            self.pictures.append(svg_url(svg))
        return self._numbers[svg]

    def _cells(self, shot: Snapshot) -> np.ndarray:
        """Returns the picture of each cell in reading order."""
        found = np.zeros((self.look.height, self.look.width), int)
        for kind in self.look.kinds:
            keys, number_of = cell_keys(kind, shot.values)
            for key in keys:
                if (kind.name, key) not in self._tiles:
                    self._tiles[kind.name, key] = self.picture_of(vector_tile(draw_cell(kind, key)))
            found[kind.rows, kind.cols] = np.array([self._tiles[kind.name, key] for key in keys])[number_of]
        return found.reshape(-1)

    def _figures(self, shot: Snapshot) -> Iterator[list[int]]:
        agents = draw_figures(self.look, shot.values, shot.heading, shot.held)
        self.colours = [_css(figure.colour) for figure in agents]
        standing = [*zip(agents, shot.row, shot.col, strict=True)]
        for herd in self.look.herds:
            standing += zip(draw_movers(herd, shot.values), *shot.movers[herd.name], strict=True)
        for figure, row, col in standing:
            if 0 <= row < self.look.height and 0 <= col < self.look.width:
                if figure not in self._bodies:
                    self._bodies[figure] = self.picture_of(vector_figure(figure))
                yield [self._bodies[figure], int(row), int(col)]


def _legend(look: Look) -> Iterator[tuple[str, str]]:
    """Yields the pictures of what can be seen, each with its text: cells, marks, then agents and movers."""
    for drawing, text in cell_entries(look):
        yield vector_tile(drawing), text
    for label, colour in look.marks:
        yield vector_tile(Drawing(mixed(look.kinds[0].ground, colour, MARKED))), label
    for figure, text in figure_entries(look):
        yield vector_figure(figure, PAPER), text


def _css(colour: Colour) -> str:
    return "#{:02x}{:02x}{:02x}".format(*colour)


def _rounded(values: np.ndarray) -> list[float]:
    return [round(float(value), DIGITS) for value in values]
