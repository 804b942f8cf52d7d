"""Decides conditions as they are when an episode begins: on declared values and on the map, for given agents and cells."""

from collections.abc import Mapping
from functools import partial
from typing import Any, NamedTuple

from sjdsl.compiler import ir
from sjdsl.compiler.ir.fold import UnknownValue
from sjdsl.compiler.ir.queries import glyphs_of, movers_named, starts_of
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
    """Returns whether a condition holds in `phase start`; None if that is not known. `names`: the number of an agent or mover, or a cell."""
    return decided(e, Evaluation(partial(_start, names=names, game=game), computes_reals=False))


def reads_only_fields(e: ir.Expr, cell: str) -> bool:
    """Returns whether a condition is the same for all cells of one character of the map: it asks for nothing of the cell but its fields."""
    nodes = list(ir.walk(e))
    owners = [
        n.owner if isinstance(n, ir.FieldRead) else n.cell
        for n in nodes
        if isinstance(n, ir.FieldRead | ir.Unoccupied)
    ]
    named = [
        [n for n in found if isinstance(n, ir.Member) and n.name == cell]
        for found in (nodes, owners)
    ]
    return len(named[0]) == len(named[1])


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
            return _in_row(_declared(game.fields, e.name), e.type)
        case ir.FieldRead(owner=ir.Member(name=name)) if name in names:
            return _in_row(_field_of(e, names[name], game), e.type)
        case ir.Attribute(owner=ir.Member(name=name)) if name in names:
            return _attribute(e.name, names[name])
        case _:
            raise UnknownValue


def _is_kept(read: ir.FieldRead, game: ir.Game) -> bool:
    """Returns whether later trials of an episode may begin with another value of a field."""
    if game.trials is None:
        return False
    if read.held_by.what == "world" and read.name == "trial":
        return True
    return any(
        kept.name == read.name and kept.held_by.overlaps(read.held_by) for kept in game.trials.kept
    )


def _field_of(e: ir.FieldRead, owner: Place | int, game: ir.Game) -> Any:
    if isinstance(owner, Place):
        meaning = next(glyph for glyph in game.glyphs if glyph.glyph == owner.glyph)
        return starts_of(game, meaning)[e.name]
    if e.held_by.what == "mover":
        return _declared(movers_named(game, e.held_by.name).fields, e.name)
    return _declared(game.agents.fields, e.name)


def _declared(fields: tuple[ir.VarField, ...], name: str) -> Any:
    return next(field.start for field in fields if field.name == name)


def _in_row(start: Any, type_: ir.Type) -> Any:
    """Returns what a variable begins with: of a row, all entries begin with the same value."""
    for level in reversed(type_.by):
        start = (start,) * len(level)
    return start


def _attribute(name: str, owner: Place | int) -> int:
    if isinstance(owner, Place) and name in ("row", "col"):
        return owner.row if name == "row" else owner.col
    if isinstance(owner, int) and name == "index":
        return owner
    raise UnknownValue
