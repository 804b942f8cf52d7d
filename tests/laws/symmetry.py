"""Agents with other numbers and a map that is mirrored, turned or moved on: where a cell, a direction, an action and an agent go."""

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random
from typing import Any

import numpy as np

from sjdsl.compiler import ir
from sjdsl.interpreter.state import HEADINGS, Cell

STEPS = ("forward", "step_right", "backward", "step_left")  # by heading, north first
SIDES = {"turn_left": "turn_right", "turn_right": "turn_left"}


@dataclass(frozen=True)
class Symmetry:
    """One way to look at a game differently.

    height, width: of the map before. order: the new number of each agent. mirror: left and right are swapped first; quarters: then
    everything is turned so many times by 90 degrees, clockwise. down, right: how far everything moves, instead, on a map that wraps.
    """

    height: int
    width: int
    order: tuple[int, ...]
    mirror: bool = False
    quarters: int = 0
    down: int = 0
    right: int = 0

    def cell(self, place: tuple[int, int]) -> Cell:
        """Returns where a cell of the map goes."""
        (row, col), height, width = place, self.height, self.width
        if self.mirror:
            col = width - 1 - col
        for _ in range(self.quarters):
            row, col, height, width = col, height - 1 - row, width, height
        return Cell((row + self.down) % height, (col + self.right) % width)

    def vector(self, rows: int, cols: int) -> tuple[int, int]:
        """Returns where a difference of two cells goes."""
        cols = -cols if self.mirror else cols
        for _ in range(self.quarters):
            rows, cols = cols, -rows
        return rows, cols

    def heading(self, heading: int) -> int:
        return ((-heading if self.mirror else heading) + self.quarters) % 4

    def facing(self, facing: str | None) -> Any:
        """Returns a direction by name; `same` and the random one stay as they are."""
        return HEADINGS[self.heading(HEADINGS.index(facing))] if facing in HEADINGS else facing

    def action(self, name: str, relative: bool) -> str:
        """Returns the action that does under the new look what this one did."""
        if name in SIDES:
            return SIDES[name] if self.mirror else name
        if name not in STEPS:
            return name
        direction = STEPS.index(name)
        return (
            STEPS[(-direction if self.mirror else direction) % 4]
            if relative
            else STEPS[self.heading(direction)]
        )

    def number(self, action: int, game: ir.Game) -> int:
        """Returns the action that asks for the agents under their new numbers: `vote(2)` for `vote(0)` where agent 0 is agent 2 now."""
        for declared in game.agents.with_arguments:
            if action in declared.numbers:
                at = np.unravel_index(
                    action - declared.first, [argument.count for argument in declared.arguments]
                )
                agents = [argument.type.kind == "agent" for argument in declared.arguments]
                place = [
                    self.order[int(i)] if is_agent else int(i)
                    for i, is_agent in zip(at, agents, strict=True)
                ]
                return declared.first + int(
                    np.ravel_multi_index(place, [argument.count for argument in declared.arguments])
                )
        return action

    def rows(self, rows: tuple[str, ...]) -> tuple[str, ...]:
        """Returns a map as it looks then."""
        glyphs = {
            self.cell((r, c)): glyph for r, row in enumerate(rows) for c, glyph in enumerate(row)
        }
        height, width = max(glyphs)
        return tuple(
            "".join(glyphs[Cell(r, c)] for c in range(width + 1)) for r in range(height + 1)
        )


def renamed(game: ir.Game, random: Random) -> Symmetry:
    """Returns agents with other numbers, each with another one if there are several."""
    number = game.agents.number
    order = list(range(number))
    while number > 1 and any(i == n for i, n in enumerate(order)):
        random.shuffle(order)
    return Symmetry(len(game.rows), len(game.rows[0]), tuple(order))


def moved_on(game: ir.Game, random: Random) -> Symmetry:
    """Returns a map that wraps moved down and to the right."""
    assert game.wraps
    size = (len(game.rows), len(game.rows[0]))
    return Symmetry(
        *size,
        tuple(range(game.agents.number)),
        down=random.randrange(size[0]),
        right=random.randrange(1, 1 + size[1]),
    )


def turns(game: ir.Game) -> Iterator[Symmetry]:
    """Yields the seven ways to mirror and turn a map."""
    for number in range(1, 8):
        yield Symmetry(
            len(game.rows),
            len(game.rows[0]),
            tuple(range(game.agents.number)),
            number >= 4,
            number % 4,
        )
