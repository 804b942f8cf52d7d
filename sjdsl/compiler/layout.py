"""Static geometry: the map as numbers, in a frame padded so that no window or shape ever leaves it.

A cell is its index in the padded frame, `(row + pad) * cols + col + pad`; 0, in the padding, is nowhere.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sjdsl.compiler import ir

DIRECTIONS = ((-1, 0), (0, 1), (1, 0), (0, -1))  # (row, col) of north, east, south, west


@dataclass(frozen=True)
class Layout:
    """The map of one game and every table that follows from it."""

    game: ir.Game

    @cached_property
    def height(self) -> int:
        return len(self.game.rows)

    @cached_property
    def width(self) -> int:
        return len(self.game.rows[0])

    @cached_property
    def pad(self) -> int:
        """Cells of padding on each side: as far as a window or a shape reaches."""
        view = self.game.window
        reach = [max(abs(a), abs(c)) for s in self.game.shapes for lane in s.lanes for a, c in lane]
        return max(view.ahead, view.behind, view.left, view.right, 1, *reach)

    @cached_property
    def cols(self) -> int:
        return self.width + 2 * self.pad

    @cached_property
    def rows(self) -> int:
        return self.height + 2 * self.pad

    def cell(self, row: int, col: int) -> int:
        """Returns the index of a map cell."""
        return (row + self.pad) * self.cols + col + self.pad

    @cached_property
    def kinds(self) -> np.ndarray:
        """`[height, width]` int: number of each cell's kind in declaration order."""
        number = {k.name: i for i, k in enumerate(self.game.kinds)}
        glyphs = {g.glyph: number[g.kind] for g in self.game.glyphs}
        return np.array([[glyphs[c] for c in row] for row in self.game.rows], np.int32)

    def sites(self, kinds: tuple[str, ...]) -> np.ndarray:
        """Returns the `[S, 2]` (row, col) of the cells of the kinds, in reading order."""
        numbers = [i for i, k in enumerate(self.game.kinds) if k.name in kinds]
        return np.argwhere(np.isin(self.kinds, numbers))

    def cells(self, kinds: tuple[str, ...]) -> np.ndarray:
        """Returns the `[S]` int32 cells of the kinds, in reading order."""
        places = self.sites(kinds)
        return ((places[:, 0] + self.pad) * self.cols + places[:, 1] + self.pad).astype(np.int32)

    def site_of(self, kinds: tuple[str, ...]) -> np.ndarray:
        """Returns, for each cell of the frame, its number among the cells of the kinds; S if it is none."""
        cells = self.cells(kinds)
        table = np.full(self.rows * self.cols, len(cells), np.int32)
        table[cells] = np.arange(len(cells))
        return table

    def starts(self, kind: str, field: ir.VarField) -> list[int | float | str | None]:
        """Returns the starting values of a kind's field, cell by cell."""
        glyphs = {g.glyph: g for g in self.game.glyphs}
        values = []
        for row, col in self.sites((kind,)):
            starts = dict(glyphs[self.game.rows[row][col]].starts)
            values.append(starts.get(field.name, field.start))
        return values

    @cached_property
    def inside(self) -> np.ndarray:
        """`[rows, cols]` bool of the frame: cells of the map."""
        frame = np.zeros((self.rows, self.cols), bool)
        frame[self.pad : self.pad + self.height, self.pad : self.pad + self.width] = True
        return frame

    def blocking(self, what: str) -> np.ndarray:
        """Returns the `[rows, cols]` bool of the frame: cells that always block agents, or a shape's lanes."""
        kinds = [i for i, k in enumerate(self.game.kinds) if any(b.what == what and b.condition is None for b in k.blocks)]
        frame = np.zeros((self.rows, self.cols), bool)
        frame[self.inside] = np.isin(self.kinds, kinds).reshape(-1)
        return frame

    @cached_property
    def next_cell(self) -> np.ndarray:
        """`[cells * 4]` int32: where a step from a cell in a direction leads; the cell itself if blocked or off the map."""
        open_ = self.inside & ~self.blocking("agents")
        cells = np.arange(self.rows * self.cols)
        table = np.stack([cells] * 4, 1)
        for direction, (dr, dc) in enumerate(DIRECTIONS):
            target = cells + dr * self.cols + dc
            valid = (target >= 0) & (target < cells.size)
            ok = np.zeros(cells.size, bool)
            ok[valid] = open_.reshape(-1)[target[valid]]
            table[ok & self.inside.reshape(-1), direction] = target[ok & self.inside.reshape(-1)]
        return table.reshape(-1).astype(np.int32)

    def shape_cells(self, shape: ir.Shape) -> list[tuple[int, int]]:
        """Returns the shape's (ahead, right) offsets, lane by lane: the order in which they are numbered."""
        return [cell for lane in shape.lanes for cell in lane]

    def offsets(self, shape: ir.Shape) -> np.ndarray:
        """Returns `[4, K]` int32: what to add to a cell for each heading and shape cell."""
        table = []
        for heading in range(4):
            ahead, right = DIRECTIONS[heading], DIRECTIONS[(heading + 1) % 4]
            table.append(
                [
                    (a * ahead[0] + c * right[0]) * self.cols + a * ahead[1] + c * right[1]
                    for a, c in self.shape_cells(shape)
                ]
            )
        return np.array(table, np.int32)

    def reach(self, shape: ir.Shape) -> np.ndarray:
        """Returns `[cells * 4, K]` bool: shape cells on the map and not behind a cell that always blocks the shape."""
        blocked = self.blocking(shape.name).reshape(-1)
        inside = self.inside.reshape(-1)
        offsets, size = self.offsets(shape), blocked.size
        table = np.zeros((size, 4, offsets.shape[1]), bool)
        for cell in np.flatnonzero(inside):
            for heading in range(4):
                number = 0
                for lane in shape.lanes:
                    live = True
                    for _ in lane:
                        target = cell + offsets[heading, number]
                        table[cell, heading, number] = live and inside[target]
                        live = live and not blocked[target]
                        number += 1
        return table.reshape(size * 4, -1)

    def neighbours(self, kinds: tuple[str, ...], shape: ir.Shape, others: tuple[str, ...]) -> np.ndarray:
        """Returns `[S, K]` int32: for each cell of the kinds, the numbers (among `others`) of the cells of the shape; none: past the end."""
        table = self.site_of(others)
        return table[self.cells(kinds)[:, None] + self.offsets(shape)[0][None]]
