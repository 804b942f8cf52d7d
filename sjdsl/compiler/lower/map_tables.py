"""Tables of the map for generated code: each is a call of a function of `sjdsl.runtime.geometry`.

A generated module contains the map as text, and computes these tables when it is loaded.
"""

from dataclasses import dataclass
from functools import cached_property

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import blocks_always, glyphs_of
from sjdsl.compiler.program.expressions import Expression, Literal, Name, call

MAP = (Name("MAP"), Name("PAD"))


def _sides(view: ir.View | ir.Window) -> tuple[Expression, ...]:
    """Returns how far a window goes ahead, behind, left and right."""
    return tuple(map(Literal, (view.ahead, view.behind, view.left, view.right)))


@dataclass(frozen=True)
class Layout:
    """The map of one game, and every table that follows from it."""

    game: ir.Game

    @property
    def height(self) -> int:
        return len(self.game.rows)

    @property
    def width(self) -> int:
        return len(self.game.rows[0])

    @property
    def wraps(self) -> bool:
        return self.game.wraps

    @property
    def _edges(self) -> dict[str, Expression]:
        """The keyword arguments of tables for a map that wraps."""
        return {"wraps": Literal(True)} if self.wraps else {}

    @cached_property
    def pad(self) -> int:
        """Cells of padding on each side: as far as a window or a shape reaches."""
        view = self.game.window
        lanes = [lane for shape in self.game.shapes for lane in shape.lanes]
        reach = [max(abs(ahead), abs(right)) for lane in lanes for ahead, right in lane]
        along = max(view.ahead, view.behind)
        across = max(view.left, view.right)
        if along == across:  # then a window could show cell 0, which stands for nowhere
            along += 1
        return max(along, across, 1, *reach)

    @property
    def cols(self) -> int:
        return self.width + 2 * self.pad

    @property
    def rows(self) -> int:
        return self.height + 2 * self.pad

    def glyphs(self, kinds: tuple[str, ...]) -> str:
        """Returns the glyphs that stand for cells of the kinds."""
        return glyphs_of(self.game, kinds)

    def num_cells(self, kinds: tuple[str, ...]) -> int:
        return self.count(self.glyphs(kinds))

    def count(self, glyphs: str) -> int:
        """Returns how many cells of the map have one of the glyphs."""
        return sum(row.count(glyph) for glyph in glyphs for row in self.game.rows)

    def cells_table(self, kinds: tuple[str, ...]) -> Expression:
        return call("cells_of", *MAP, self.glyphs(kinds))

    def site_table(self, kinds: tuple[str, ...]) -> Expression:
        """The number of each cell of the frame among the cells of the kinds; past the end: none."""
        return call("site_numbers", *MAP, self.cells_table(kinds))

    def order_table(self, kinds: tuple[str, ...]) -> Expression:
        """The places of a group's cells in reading order, where they are listed kind by kind."""
        return call("reading_order", MAP[0], [self.glyphs((kind,)) for kind in kinds])

    def numbers_table(self, group: tuple[str, ...], kind: str) -> Expression:
        """The number of each cell of a group among the cells of one kind.

        It is past the end for cells of other kinds, and once more at the end.
        """
        return call("numbers_among", MAP[0], self.glyphs(group), self.glyphs((kind,)))

    def starts_table(
        self, kind: str, field: ir.VarField, encode: "dict[object, float]", dtype: str
    ) -> Expression:
        """The starting values of a kind's field, cell by cell.

        encode: a starting value as the game writes it -> the number that is stored.
        """
        values = {}
        for meaning in self.game.glyphs:
            if meaning.kind == kind:
                values[meaning.glyph] = encode[dict(meaning.starts).get(field.name, field.start)]
        return call("values_of", MAP[0], values, dtype)

    def starts(self, kind: str, field: ir.VarField) -> set[object]:
        """Returns the starting values that a kind's field has on this map."""
        glyphs = set().union(*self.game.rows)
        on_map = [g for g in self.game.glyphs if g.kind == kind and g.glyph in glyphs]
        return {dict(g.starts).get(field.name, field.start) for g in on_map}

    def base_table(self, looks: dict[str, int]) -> Expression:
        """The frame painted with a number for each kind. looks: kind -> its number."""
        return call("painted", *MAP, {g.glyph: looks[g.kind] for g in self.game.glyphs})

    @property
    def view_table(self) -> Expression:
        """What to add to an observer's cell for each heading and each cell of its window."""
        return call("view_offsets", *MAP, *self._view)

    @property
    def steps_table(self) -> Expression:
        """The steps from an observer to each cell of its window."""
        if self.wraps:
            return call("view_steps_around", MAP[0], *self._view)
        return call("view_steps", *self._view)

    def view_cells_table(self, view: ir.View) -> Expression:
        """Which cells of what an observation covers are in a window."""
        return call("view_cells", *self._view, *_sides(view))

    @property
    def _view(self) -> tuple[Expression, ...]:
        return _sides(self.game.window)

    @property
    def shows_cells_twice(self) -> bool:
        """Whether a window can go round the map and show the observer's own cell once more."""
        view = self.game.window
        farthest = max(view.ahead, view.behind, view.left, view.right)
        return self.wraps and farthest >= min(self.height, self.width)

    @property
    def own_cells_table(self) -> Expression:
        """Which cells of a window show the observer's own cell, for each heading."""
        return call("own_cells", MAP[0], *self._view)

    @property
    def edges_table(self) -> Expression:
        """The cell of the map that each cell of the frame is, if the map wraps."""
        return call("around_edges", *MAP)

    @property
    def inside_table(self) -> Expression:
        return call("inside", *MAP)

    def blocking_glyphs(self, name: str) -> str:
        """Returns the glyphs of cells that always block agents, movers, or a shape's lanes."""
        kinds = [kind.name for kind in self.game.kinds if blocks_always(kind, name)]
        return self.glyphs(tuple(kinds))

    def blocking_table(self, name: str) -> Expression:
        return call("blocking", *MAP, self.blocking_glyphs(name))

    def next_table(self, name: str = "agents") -> Expression:
        """The cell that a step leads agents or movers to, by cell and direction."""
        return call("next_cells", *MAP, self.blocking_glyphs(name), **self._edges)

    def offsets_table(self, shape: ir.Shape) -> Expression:
        """What to add to a cell for each heading and each cell of a shape, lane by lane."""
        cells = tuple(cell for lane in shape.lanes for cell in lane)
        return call("shape_offsets", *MAP, cells, **self._edges)

    def reach_table(self, shape: ir.Shape) -> Expression:
        """The cells of a shape on the map and not behind what always blocks it.

        They are bits, by cell and heading.
        """
        lanes = tuple(map(len, shape.lanes))
        glyphs = self.blocking_glyphs(shape.name)
        return call("lane_reach", *MAP, self.offsets_table(shape), lanes, glyphs, **self._edges)

    def neighbours_table(
        self, kinds: tuple[str, ...], shape: ir.Shape, others: tuple[str, ...]
    ) -> Expression:
        """The cells of a shape around each cell, by number among `others`; past the end: none."""
        numbers = self.site_table(others)
        if self.wraps:
            numbers = numbers[self.edges_table]
        return call("neighbours", self.cells_table(kinds), numbers, self.offsets_table(shape))

    def near_table(
        self, kinds: tuple[str, ...], shape: ir.Shape, others: tuple[str, ...]
    ) -> Expression:
        """The neighbours of each cell as bits."""
        neighbours = self.neighbours_table(kinds, shape, others)
        return call("near_masks", neighbours, self.num_cells(others))
