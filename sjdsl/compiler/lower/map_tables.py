"""Tables of the map for lowered code: glyphs of kinds, cells, padding, and the expression that builds each table."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import blocks_always, glyphs_of
from sjdsl.compiler.program.expressions import Expression, Literal, Name, call, constant
from sjdsl.runtime import geometry


@dataclass(frozen=True)
class Table:
    """A constant array, and the expression that computes it in a generated module."""

    value: np.ndarray
    node: Expression


MAP = (Name("MAP"), Name("PAD"))


@dataclass(frozen=True)
class Layout:
    """The map of one game and every table that follows from it."""

    game: ir.Game

    @property
    def map(self) -> tuple[str, ...]:
        return self.game.rows

    @property
    def height(self) -> int:
        return len(self.game.rows)

    @property
    def width(self) -> int:
        return len(self.game.rows[0])

    @cached_property
    def pad(self) -> int:
        """Cells of padding on each side: as far as a window or a shape reaches."""
        view = self.game.window
        reach = [max(abs(a), abs(c)) for s in self.game.shapes for lane in s.lanes for a, c in lane]
        along, across = max(view.ahead, view.behind), max(view.left, view.right)
        corner = along == across  # then a window could show cell 0, which stands for nowhere
        return max(along + corner, across + corner, 1, *reach)

    @property
    def cols(self) -> int:
        return self.width + 2 * self.pad

    @property
    def rows(self) -> int:
        return self.height + 2 * self.pad

    def glyphs(self, kinds: tuple[str, ...]) -> str:
        """Returns the glyphs that stand for cells of the kinds."""
        return glyphs_of(self.game, kinds)

    def cells(self, kinds: tuple[str, ...]) -> np.ndarray:
        """Returns the `[S]` int32 cells of the kinds, in reading order."""
        return geometry.cells_of(self.map, self.pad, self.glyphs(kinds))

    def num_cells(self, kinds: tuple[str, ...]) -> int:
        return sum(row.count(glyph) for glyph in self.glyphs(kinds) for row in self.map)

    def cells_table(self, kinds: tuple[str, ...]) -> Table:
        return Table(self.cells(kinds), call("cells_of", *MAP, Literal(self.glyphs(kinds))))

    def site_of(self, kinds: tuple[str, ...]) -> np.ndarray:
        """Returns, for each cell of the frame, its number among the cells of the kinds; past the end if it is none."""
        return geometry.site_numbers(self.map, self.pad, self.cells(kinds))

    def site_table(self, kinds: tuple[str, ...]) -> Table:
        return Table(self.site_of(kinds), call("site_numbers", *MAP, self.cells_table(kinds).node))

    def starts_table(self, kind: str, field: ir.VarField, encode: "dict[object, float]", dtype: str) -> Table:
        """Returns the starting values of a kind's field, cell by cell."""
        values = {g.glyph: encode[dict(g.starts).get(field.name, field.start)] for g in self.game.glyphs if g.kind == kind}
        return Table(geometry.values_of(self.map, values, dtype), call("values_of", Name("MAP"), constant(values), Literal(dtype)))

    def starts(self, kind: str, field: ir.VarField) -> set[object]:
        """Returns the starting values that a kind's field has on this map."""
        used = {g for row in self.map for g in row}
        return {dict(g.starts).get(field.name, field.start) for g in self.game.glyphs if g.kind == kind and g.glyph in used}

    def base_table(self, looks: dict[str, int]) -> Table:
        """Returns the frame painted with one number a kind."""
        values = {g.glyph: looks[g.kind] for g in self.game.glyphs}
        return Table(geometry.painted(self.map, self.pad, values), call("painted", *MAP, constant(values)))

    @cached_property
    def inside_table(self) -> Table:
        return Table(geometry.inside(self.map, self.pad), call("inside", *MAP))

    def blocking_glyphs(self, what: str) -> str:
        """Returns the glyphs of cells that always block agents, or a shape's lanes."""
        kinds = tuple(kind.name for kind in self.game.kinds if blocks_always(kind, what))
        return self.glyphs(kinds)

    def blocking_table(self, what: str) -> Table:
        glyphs = self.blocking_glyphs(what)
        return Table(geometry.blocking(self.map, self.pad, glyphs), call("blocking", *MAP, Literal(glyphs)))

    @cached_property
    def next_table(self) -> Table:
        """Where a step from a cell in a direction leads."""
        glyphs = self.blocking_glyphs("agents")
        return Table(geometry.next_cells(self.map, self.pad, glyphs), call("next_cells", *MAP, Literal(glyphs)))

    def shape_cells(self, shape: ir.Shape) -> tuple[tuple[int, int], ...]:
        """Returns the shape's (ahead, right) offsets, lane by lane: the order in which they are numbered."""
        return tuple(cell for lane in shape.lanes for cell in lane)

    def offsets(self, shape: ir.Shape) -> np.ndarray:
        """Returns `[4, K]` int32: what to add to a cell for each heading and shape cell."""
        return geometry.shape_offsets(self.map, self.pad, self.shape_cells(shape))

    def offsets_table(self, shape: ir.Shape) -> Table:
        return Table(self.offsets(shape), call("shape_offsets", *MAP, constant(self.shape_cells(shape))))

    def reach_table(self, shape: ir.Shape) -> Table:
        """Which cells of the shape are on the map and not behind what always blocks it: bits by cell and heading."""
        glyphs, lanes = self.blocking_glyphs(shape.name), tuple(map(len, shape.lanes))
        offsets = self.offsets_table(shape)
        value = geometry.lane_reach(self.map, self.pad, offsets.value, lanes, glyphs)
        return Table(value, call("lane_reach", *MAP, offsets.node, constant(lanes), Literal(glyphs)))

    def neighbours_table(self, kinds: tuple[str, ...], shape: ir.Shape, others: tuple[str, ...]) -> Table:
        """For each cell of the kinds, the numbers (among `others`) of the cells of the shape; past the end: none."""
        value = geometry.neighbours(self.cells(kinds), self.site_of(others), self.offsets(shape))
        parts = (self.cells_table(kinds), self.site_table(others), self.offsets_table(shape))
        return Table(value, call("neighbours", *(p.node for p in parts)))

    def near_table(self, kinds: tuple[str, ...], shape: ir.Shape, others: tuple[str, ...]) -> Table:
        """The neighbours of each cell as bits."""
        around, size = self.neighbours_table(kinds, shape, others), self.num_cells(others)
        return Table(geometry.near_masks(around.value, size), call("near_masks", around.node, Literal(size)))
