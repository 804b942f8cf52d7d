"""Decides conditions on the values with which an episode begins, for given agents and cells."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from sjdsl.compiler import ir
from sjdsl.compiler.ir.fold import UnknownValue
from sjdsl.compiler.ir.queries import are_one_field, declared_field, glyphs_of, starts_of
from sjdsl.compiler.ir.values import Evaluation, decided


class Place(NamedTuple):
    """A cell of the map, with its character."""

    row: int
    col: int
    glyph: str


def places(game: ir.Game, kinds: tuple[str, ...]) -> list[Place]:
    """Returns the cells of some kinds, in reading order."""
    glyphs = glyphs_of(game, kinds)
    return [
        Place(r, c, glyph)
        for r, row in enumerate(game.rows)
        for c, glyph in enumerate(row)
        if glyph in glyphs
    ]


def holds_at_start(e: ir.Expr, names: Mapping[str, Place | int], game: ir.Game) -> bool | None:
    """Returns whether a condition holds in `phase start`; None if that is not known.

    names: of variables, each with a cell or the number of an agent or mover.
    """
    return decided(e, Evaluation(partial(_start, names=names, game=game), computes_reals=False))


def reads_only_fields(e: ir.Expr, cell: str) -> bool:
    """Returns whether a condition is the same for all cells of one character of the map.

    It then reads nothing of the cell but its fields, and whether somebody stands on it.
    """
    nodes = list(ir.walk(e))
    read: list[ir.Node | None] = [n.owner for n in nodes if isinstance(n, ir.FieldRead)]
    read += [n.cell for n in nodes if isinstance(n, ir.Unoccupied)]

    def times_named(among: Sequence[ir.Node | None]) -> int:
        return sum(isinstance(node, ir.Member) and node.name == cell for node in among)

    return times_named(nodes) == times_named(read)


def _start(e: ir.Expr, names: Mapping[str, Place | int], game: ir.Game) -> Any:
    """Returns what is read when the episode begins. Raises UnknownValue."""
    match e:
        case ir.Step():
            return 0
        case ir.Unoccupied():
            return True
        case ir.Member(name=name) if name in names:
            return names[name]
        case ir.FieldRead() if _is_kept(e, game):
            raise UnknownValue  # in later trials it is what the trial before left
        case ir.FieldRead(owner=None):
            return _in_row(declared_field(game, e).start, e.type)
        case ir.FieldRead(owner=ir.Member(name=name)) if name in names:
            owner = names[name]
            start = declared_field(game, e).start
            if isinstance(owner, Place):
                meaning = next(glyph for glyph in game.glyphs if glyph.glyph == owner.glyph)
                start = starts_of(game, meaning)[e.name]
            return _in_row(start, e.type)
        case ir.Attribute(name="row" | "col", owner=ir.Member(name=name)):
            if isinstance(names.get(name), Place):
                return getattr(names[name], e.name)
        case ir.Attribute(name="index", owner=ir.Member(name=name)):
            if isinstance(names.get(name), int):
                return names[name]
    raise UnknownValue


def _is_kept(read: ir.FieldRead, game: ir.Game) -> bool:
    """Returns whether a field isn't as declared at the start: a task or a trial before set it."""
    if game.task is not None and read.held_by.what == "world" and read.name in game.task.fields:
        return True
    if game.trials is None:
        return False
    if read.held_by.what == "world" and read.name == "trial":
        return True
    return any(are_one_field(kept, read) for kept in game.trials.kept)


def _in_row(start: Any, type_: ir.Type) -> Any:
    """Returns what a variable begins with: of a row, all entries begin with the same value."""
    for index_set in reversed(type_.indexed_by):
        start = (start,) * len(index_set)
    return start
