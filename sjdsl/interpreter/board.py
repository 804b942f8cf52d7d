"""The constant parts of a game: the kind of every cell, the cells of every kind, declarations by name."""

from dataclasses import dataclass, field
from functools import cached_property, lru_cache

from sjdsl.compiler import ir
from sjdsl.compiler.ir import printer
from sjdsl.compiler.ir.queries import (
    all_fields,
    contains,
    kinds_by_glyph,
    marking_phases,
    phases_of,
)
from sjdsl.interpreter import planes
from sjdsl.interpreter.state import Cell, Herd, Pool, Value, World, field_value


@dataclass(frozen=True, eq=False)
class Board:
    """A game with its map read.

    kind_of: every cell of the map. cells: those of a kind, in reading order. number: of a cell among its own kind's.
    pools: a `send` of each pool of sends, the first one with `after` if there is one; start first, then in the order of the schedule.
    fields: those declared, by whose they are (a kind, a sort of movers, `agent` or `world`) and their names.
    moving: the phases in which agents move, by their identity.
    closed: whether an expression names nothing around it, as far as asked, by its identity.
    read: what an observable reads, as far as asked, by its identity.
    """

    game: ir.Game
    kind_of: dict[Cell, str]
    cells: dict[str, tuple[Cell, ...]]
    number: dict[Cell, int]
    kinds: dict[str, ir.Kind]
    shapes: dict[str, ir.Shape]
    fields: dict[tuple[str, str], ir.VarField]
    pools: dict[Pool, ir.Send]
    moving: frozenset[int]
    closed: dict[int, tuple[ir.Expr, bool]] = field(default_factory=dict)
    read: dict[int, tuple[ir.Observable, ir.Expr]] = field(default_factory=dict)

    @property
    def agents(self) -> int:
        return self.game.agents.number

    @cached_property
    def planes(self) -> tuple[planes.Plane, ...]:
        """What an observation shows."""
        return planes.planes(self.game)

    @cached_property
    def content_codes(self) -> dict[str, int]:
        """The number that stands for each look of a cell."""
        return {label: code for code, label in enumerate(planes.content_labels(self.game))}

    @cached_property
    def marking(self) -> tuple[ir.Phase, ...]:
        """The phases that mark cells."""
        return marking_phases(self.game)

    def at(self, row: int, col: int) -> Cell | None:
        """Returns the cell of the map at a place, which may lie beyond the edges; None if there is none."""
        if self.game.wraps:
            row, col = row % len(self.game.rows), col % len(self.game.rows[0])
        cell = Cell(row, col)
        return cell if cell in self.kind_of else None

    def apart(self, a: Cell, b: Cell) -> tuple[int, int]:
        """Returns how many rows down and columns to the right b is from a: the shorter way round, the positive one of two equal ways."""
        rows, cols = b.row - a.row, b.col - a.col
        if not self.game.wraps:
            return rows, cols
        height, width = len(self.game.rows), len(self.game.rows[0])
        rows, cols = rows % height, cols % width
        return rows - height * (2 * rows > height), cols - width * (2 * cols > width)

    def steps(self, a: Cell, b: Cell) -> int:
        """Returns the steps between two cells along rows and columns."""
        return sum(map(abs, self.apart(a, b)))


@lru_cache(maxsize=256)
def cells_of(board: Board, kinds: tuple[str, ...]) -> tuple[Cell, ...]:
    """Returns the cells of all these kinds together, in reading order."""
    return tuple(sorted(cell for kind in set(kinds) for cell in board.cells[kind]))


_latest: list[Board] = []
KEPT = 8  # two games may be played step by step side by side


def board_of(game: ir.Game) -> Board:
    """Returns the board of a game; those asked for last are kept."""
    for board in _latest:
        if board.game is game:
            return board
    _latest[:] = [_build(game), *_latest[: KEPT - 1]]
    return _latest[0]


def _build(game: ir.Game) -> Board:
    meaning = kinds_by_glyph(game)
    kind_of = {
        Cell(r, c): meaning[glyph] for r, row in enumerate(game.rows) for c, glyph in enumerate(row)
    }
    cells = {k.name: tuple(cell for cell in kind_of if kind_of[cell] == k.name) for k in game.kinds}
    return Board(
        game=game,
        kind_of=kind_of,
        cells=cells,
        number={cell: number for members in cells.values() for number, cell in enumerate(members)},
        kinds={k.name: k for k in game.kinds},
        shapes={s.name: s for s in (*game.shapes, *game.policy_shapes)},
        fields={(f.held_by.name, f.name): f for f in all_fields(game)},
        pools=_pools(game),
        moving=frozenset(id(phase) for phase in phases_of(game) if contains(phase, ir.Move)),
    )


def _pools(game: ir.Game) -> dict[Pool, ir.Send]:
    pools: dict[Pool, ir.Send] = {}
    for phase in phases_of(game):
        for node in ir.walk(phase):
            if isinstance(node, ir.Send):
                pool = Pool(phase.name, node.pool)
                first = pools.setdefault(pool, node)
                if (
                    first.after is None and node.after is not None
                ):  # the one that those who come back were sent by
                    pools[pool] = node
                destinations = [
                    (printer.domain(s.domain), s.cell_stream, s.heading_stream)
                    for s in (first, node)
                ]
                assert destinations[0] == destinations[1], f"{pool} is split"
    return pools


def declared_world(board: Board, params: dict[str, Value]) -> World:
    """Returns the state before the phase `start`: declared values, the map's own, nobody placed yet."""
    game = board.game
    starts = {g.glyph: dict(g.starts) for g in game.glyphs}
    cells = {
        (kind, name): [
            field_value(f, starts.get(game.rows[r][c], {}).get(name, f.start))
            for r, c in board.cells[kind]
        ]
        for (kind, name), f in board.fields.items()
        if f.held_by.what == "cell"
    }
    return World(
        step=0,
        cells=cells,
        agents={f.name: [field_value(f, f.start)] * board.agents for f in game.agents.fields},
        fields={f.name: field_value(f, f.start) for f in game.fields},
        position=[None] * board.agents,
        heading=[0] * board.agents,
        moved=[False] * board.agents,
        away=[None] * board.agents,
        marks=[],
        params=dict(params),
        movers={sort.name: _declared_herd(sort) for sort in game.movers},
    )


def _declared_herd(sort: ir.Movers) -> Herd:
    fields = {f.name: [field_value(f, f.start)] * sort.number for f in sort.fields}
    return Herd([None] * sort.number, [False] * sort.number, [None] * sort.number, fields)
