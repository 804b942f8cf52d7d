"""The constant parts of a game.

The kind of every cell, the cells of every kind, declarations by name.
"""

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
from sjdsl.interpreter.shapes import FORWARD
from sjdsl.interpreter.state import Cell, Herd, Pool, Value, World, field_value


@dataclass(frozen=True, eq=False)
class Board:
    """A game with its map as a table of cells."""

    game: ir.Game
    kind_of: dict[Cell, str]  # of every cell of the map
    cells: dict[str, tuple[Cell, ...]]  # those of a kind, in reading order
    number: dict[Cell, int]  # of a cell among those of its kind
    kinds: dict[str, ir.Kind]
    shapes: dict[str, ir.Shape]
    # By their owners (a kind, an entity type of movers, `agent` or `world`) and their names.
    fields: dict[tuple[str, str], ir.VarField]
    # A `send` of each pool, the first one with `after` if there is one; those of the phase `start`
    # first, then in the order of the schedule.
    pools: dict[Pool, ir.Send]
    moving: frozenset[int]  # the identities of the phases in which agents move
    # Caches by identity: whether an expression has no free variables, and the expression that an
    # observable shows.
    closed: dict[int, tuple[ir.Expr, bool]] = field(default_factory=dict)
    read: dict[int, tuple[ir.Observable, ir.Expr]] = field(default_factory=dict)

    @property
    def agents(self) -> int:
        return self.game.agents.number

    @cached_property
    def planes(self) -> tuple[planes.Plane, ...]:
        """The planes of an observation."""
        return planes.planes(self.game)

    @cached_property
    def content_codes(self) -> dict[str, int]:
        """The token of each label of the content plane."""
        return {label: code for code, label in enumerate(planes.content_labels(self.game))}

    @cached_property
    def marking(self) -> tuple[ir.Phase, ...]:
        """The phases that mark cells."""
        return marking_phases(self.game)

    def at(self, row: int, col: int) -> Cell | None:
        """Returns the cell at a place, which may lie beyond the edges of the map.

        None if there is none.
        """
        if self.game.wraps:
            row %= len(self.game.rows)
            col %= len(self.game.rows[0])
        cell = Cell(row, col)
        return cell if cell in self.kind_of else None

    def offset(self, a: Cell, b: Cell) -> tuple[int, int]:
        """Returns how many rows down and columns to the right b is from a.

        On a map that wraps, that is the shorter way round; the positive one of two equal ways.
        """
        rows = b.row - a.row
        cols = b.col - a.col
        if not self.game.wraps:
            return rows, cols
        height = len(self.game.rows)
        width = len(self.game.rows[0])
        return _shorter_way(rows, height), _shorter_way(cols, width)

    def steps(self, a: Cell, b: Cell) -> int:
        """Returns the steps between two cells along rows and columns."""
        return sum(map(abs, self.offset(a, b)))

    def steps_toward(self, heading: int, a: Cell, b: Cell) -> int:
        """Returns how many steps b is ahead of a in the direction of a heading, negative if behind.

        Steps across that direction don't count. On a map that wraps it is the shorter way round;
        the positive one of two equal ways.
        """
        rows, cols = FORWARD[heading]
        steps = rows * (b.row - a.row) + cols * (b.col - a.col)
        if not self.game.wraps:
            return steps
        return _shorter_way(steps, len(self.game.rows if rows else self.game.rows[0]))


def _shorter_way(distance: int, size: int) -> int:
    """Returns the shorter of the two ways round a circle of `size` cells."""
    distance %= size
    return distance - size if 2 * distance > size else distance


@lru_cache(maxsize=256)
def cells_of(board: Board, kinds: tuple[str, ...]) -> tuple[Cell, ...]:
    """Returns the cells of all these kinds together, in reading order."""
    return tuple(sorted(cell for kind in set(kinds) for cell in board.cells[kind]))


_latest: list[Board] = []
CACHE_SIZE = 8  # boards: several games may be played side by side


def board_of(game: ir.Game) -> Board:
    """Returns the board of a game; those of the games asked for last are cached."""
    for board in _latest:
        if board.game is game:
            return board
    _latest[:] = [_build(game), *_latest[: CACHE_SIZE - 1]]
    return _latest[0]


def _build(game: ir.Game) -> Board:
    """Returns a new board of a game."""
    kind_of_glyph = kinds_by_glyph(game)
    kind_of: dict[Cell, str] = {}
    number: dict[Cell, int] = {}
    cells: dict[str, list[Cell]] = {kind.name: [] for kind in game.kinds}
    for row, glyphs in enumerate(game.rows):
        for col, glyph in enumerate(glyphs):
            cell = Cell(row, col)
            kind_of[cell] = kind_of_glyph[glyph]
            number[cell] = len(cells[kind_of[cell]])
            cells[kind_of[cell]].append(cell)
    return Board(
        game=game,
        kind_of=kind_of,
        cells={kind: tuple(members) for kind, members in cells.items()},
        number=number,
        kinds={kind.name: kind for kind in game.kinds},
        shapes={shape.name: shape for shape in (*game.shapes, *game.policy_shapes)},
        fields={(declared.held_by.name, declared.name): declared for declared in all_fields(game)},
        pools=_pools(game),
        moving=frozenset(id(phase) for phase in phases_of(game) if contains(phase, ir.Move)),
    )


def _pools(game: ir.Game) -> dict[Pool, ir.Send]:
    """Returns a `send` of each pool: the first one with `after`, or else the first."""
    pools: dict[Pool, ir.Send] = {}
    for phase in phases_of(game):
        for node in ir.walk(phase):
            if isinstance(node, ir.Send):
                pool = Pool(phase.name, node.pool)
                first = pools.setdefault(pool, node)
                if first.after is None and node.after is not None:
                    pools[pool] = node  # the statement that those who come back were sent by
                assert _destination(first) == _destination(node), f"{pool} is split"
    return pools


def _destination(send: ir.Send) -> tuple[str, int, int]:
    """Returns the destination as written and the streams of its draws, equal in a pool."""
    return printer.domain_text(send.domain), send.cell_stream, send.heading_stream


def declared_world(board: Board, params: dict[str, Value]) -> World:
    """Returns the state before the phase `start`.

    Fields as declared or as the map says, nobody placed.
    """
    game = board.game
    starts = {glyph.glyph: dict(glyph.starts) for glyph in game.glyphs}
    cells: dict[tuple[str, str], list[Value]] = {}
    for (kind, name), declared in board.fields.items():
        if declared.held_by.what == "cell":
            glyphs = [game.rows[row][col] for row, col in board.cells[kind]]
            cells[kind, name] = [
                field_value(declared, starts.get(glyph, {}).get(name, declared.start))
                for glyph in glyphs
            ]
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
        movers={movers.name: _declared_herd(movers) for movers in game.movers},
    )


def _declared_herd(movers: ir.Movers) -> Herd:
    """Returns the movers of an entity type before the phase `start`."""
    fields = {f.name: [field_value(f, f.start)] * movers.number for f in movers.fields}
    return Herd([None] * movers.number, [False] * movers.number, [None] * movers.number, fields)
