"""Tables of the map for lowered code: glyphs of kinds, padding, and the expression that makes each table when a module is loaded."""

from dataclasses import dataclass
from functools import cached_property

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import blocks_always, glyphs_of
from sjdsl.compiler.program.expressions import Expression, Index, Literal, Name, call, constant

MAP = (Name("MAP"), Name("PAD"))


def _sides(view: ir.View | ir.Window) -> tuple[Expression, ...]:
    """Returns how far a window goes ahead, behind, left and right."""
    return tuple(map(Literal, (view.ahead, view.behind, view.left, view.right)))


@dataclass(frozen=True)
class Layout:
    """The map of one game and every table that follows from it: a call of what `sjdsl.runtime.geometry` has."""

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
        """What tables of a map that wraps are told."""
        return {"wraps": Literal(True)} if self.wraps else {}

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

    def num_cells(self, kinds: tuple[str, ...]) -> int:
        return self.count(self.glyphs(kinds))

    def count(self, glyphs: str) -> int:
        """Returns how many cells of the map have one of the glyphs."""
        return sum(row.count(glyph) for glyph in glyphs for row in self.game.rows)

    def cells_table(self, kinds: tuple[str, ...]) -> Expression:
        return call("cells_of", *MAP, Literal(self.glyphs(kinds)))

    def site_table(self, kinds: tuple[str, ...]) -> Expression:
        """The number of each cell of the frame among the cells of the kinds; past the end if it is none."""
        return call("site_numbers", *MAP, self.cells_table(kinds))

    def order_table(self, kinds: tuple[str, ...]) -> Expression:
        """Where each cell of a group stands among those of its kinds, one kind after another."""
        return call("reading_order", MAP[0], constant([self.glyphs((kind,)) for kind in kinds]))

    def numbers_table(self, group: tuple[str, ...], kind: str) -> Expression:
        """The number of each cell of a group among the cells of one kind; past the end if it is none, and once more at the end."""
        return call(
            "numbers_among", MAP[0], Literal(self.glyphs(group)), Literal(self.glyphs((kind,)))
        )

    def starts_table(
        self, kind: str, field: ir.VarField, encode: "dict[object, float]", dtype: str
    ) -> Expression:
        """The starting values of a kind's field, cell by cell."""
        values = {
            g.glyph: encode[dict(g.starts).get(field.name, field.start)]
            for g in self.game.glyphs
            if g.kind == kind
        }
        return call("values_of", MAP[0], constant(values), Literal(dtype))

    def starts(self, kind: str, field: ir.VarField) -> set[object]:
        """Returns the starting values that a kind's field has on this map."""
        used = {g for row in self.game.rows for g in row}
        return {
            dict(g.starts).get(field.name, field.start)
            for g in self.game.glyphs
            if g.kind == kind and g.glyph in used
        }

    def base_table(self, looks: dict[str, int]) -> Expression:
        """The frame painted with one number a kind."""
        return call("painted", *MAP, constant({g.glyph: looks[g.kind] for g in self.game.glyphs}))

    @property
    def view_table(self) -> Expression:
        """What to add to an observer's cell for each heading and each cell of its window."""
        return call("view_offsets", *MAP, *self._view)

    @property
    def steps_table(self) -> Expression:
        """The steps from an observer to each cell of its window."""
        return (
            call("view_steps_around", MAP[0], *self._view)
            if self.wraps
            else call("view_steps", *self._view)
        )

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
        return self.wraps and max(view.ahead, view.behind, view.left, view.right) >= min(
            self.height, self.width
        )

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

    def blocking_glyphs(self, what: str) -> str:
        """Returns the glyphs of cells that always block agents, or a shape's lanes."""
        return self.glyphs(
            tuple(kind.name for kind in self.game.kinds if blocks_always(kind, what))
        )

    def blocking_table(self, what: str) -> Expression:
        return call("blocking", *MAP, Literal(self.blocking_glyphs(what)))

    def next_table(self, what: str = "agents") -> Expression:
        """Where a step from a cell in a direction leads agents, or movers of a sort."""
        return call("next_cells", *MAP, Literal(self.blocking_glyphs(what)), **self._edges)

    def offsets_table(self, shape: ir.Shape) -> Expression:
        """What to add to a cell for each heading and each cell of a shape, which are numbered lane by lane."""
        return call(
            "shape_offsets",
            *MAP,
            constant(tuple(cell for lane in shape.lanes for cell in lane)),
            **self._edges,
        )

    def reach_table(self, shape: ir.Shape) -> Expression:
        """Which cells of the shape are on the map and not behind what always blocks it: bits by cell and heading."""
        lanes = constant(tuple(map(len, shape.lanes)))
        glyphs = Literal(self.blocking_glyphs(shape.name))
        return call("lane_reach", *MAP, self.offsets_table(shape), lanes, glyphs, **self._edges)

    def neighbours_table(
        self, kinds: tuple[str, ...], shape: ir.Shape, others: tuple[str, ...]
    ) -> Expression:
        """For each cell of the kinds, the numbers (among `others`) of the cells of the shape; past the end: none."""
        numbers = (
            Index(self.site_table(others), (self.edges_table,))
            if self.wraps
            else self.site_table(others)
        )
        return call("neighbours", self.cells_table(kinds), numbers, self.offsets_table(shape))

    def near_table(
        self, kinds: tuple[str, ...], shape: ir.Shape, others: tuple[str, ...]
    ) -> Expression:
        """The neighbours of each cell as bits."""
        return call(
            "near_masks",
            self.neighbours_table(kinds, shape, others),
            Literal(self.num_cells(others)),
        )
