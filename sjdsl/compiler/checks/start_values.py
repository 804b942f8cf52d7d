"""Decides conditions as they are when an episode begins: on declared values and on the map, for given agents and cells."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from sjdsl.compiler import ir
from sjdsl.compiler.ir.operations import CALCULATIONS, COMPARISONS
from sjdsl.compiler.ir.queries import glyphs_of, movers_named, starts_of


class Place(NamedTuple):
    """A cell of the map, with its character."""

    row: int
    col: int
    glyph: str


class NotKnown(Exception):
    """Something that is not known before the game is played."""


def places(game: ir.Game, kinds: tuple[str, ...]) -> list[Place]:
    """Returns the cells of some kinds, in reading order."""
    glyphs = glyphs_of(game, kinds)
    return [Place(r, c, glyph) for r, row in enumerate(game.rows) for c, glyph in enumerate(row) if glyph in glyphs]


def holds_at_start(e: ir.Expr, names: Mapping[str, Place | int], game: ir.Game) -> bool | None:
    """Returns whether a condition holds in `phase start`; None if that is not known. `names`: the number of an agent or mover, or a cell."""
    try:
        return bool(_value(e, names, game))
    except NotKnown:
        return None


def reads_only_fields(e: ir.Expr, cell: str) -> bool:
    """Returns whether a condition is the same for all cells of one character of the map: it asks for nothing of the cell but its fields."""
    nodes = list(ir.walk(e))
    owners = [n.owner if isinstance(n, ir.FieldRead) else n.cell for n in nodes if isinstance(n, ir.FieldRead | ir.Unoccupied)]
    named = [[n for n in found if isinstance(n, ir.Member) and n.name == cell] for found in (nodes, owners)]
    return len(named[0]) == len(named[1])


def _value(e: ir.Expr, names: Mapping[str, Place | int], game: ir.Game) -> Any:
    match e:
        case ir.Number() | ir.Word() | ir.Truth():
            return e.value
        case ir.Nobody():
            return None
        case ir.Step():
            return 0
        case ir.Member() if e.name in names:
            return names[e.name]
        case ir.FieldRead():
            return _start(e, names, game)
        case ir.At(key=ir.Word()):  # every entry of a row begins with the same value
            return _value(e.row, names, game)
        case ir.Attribute():
            return _attribute(e, names)
        case ir.Named() | ir.Narrowed():
            return _value(e.value, names, game)
        case ir.Arithmetic():
            return _number(e, names, game)
        case _:
            return _condition(e, names, game)


def _start(e: ir.FieldRead, names: Mapping[str, Place | int], game: ir.Game) -> Any:
    if isinstance(e.owner, ir.Member) and e.owner.name in names:
        place = names[e.owner.name]
        if isinstance(place, Place):
            return starts_of(game, next(g for g in game.glyphs if g.glyph == place.glyph))[e.name]
        fields = movers_named(game, e.held_by.name).fields if e.held_by.what == "mover" else game.agents.fields
        return next(f.start for f in fields if f.name == e.name)
    if e.owner is None:
        return next(f.start for f in game.fields if f.name == e.name)
    raise NotKnown


def _attribute(e: ir.Attribute, names: Mapping[str, Place | int]) -> int:
    who = names.get(e.owner.name) if isinstance(e.owner, ir.Member) else None
    match who, e.name:
        case Place(), "row":
            return who.row
        case Place(), "col":
            return who.col
        case int(), "index":
            return who
        case _:
            raise NotKnown


def _number(e: ir.Arithmetic, names: Mapping[str, Place | int], game: ir.Game) -> Any:
    """Returns what is calculated from whole numbers; reals are rounded in play."""
    if any(part.type.kind != "int" for part in (e, *e.args)):
        raise NotKnown
    row, values = CALCULATIONS[e.fn], [_value(a, names, game) for a in e.args]
    if row.divisor is not None and not values[row.divisor]:
        raise NotKnown
    return row.fold(*values)


def _condition(e: ir.Expr, names: Mapping[str, Place | int], game: ir.Game) -> bool:
    match e:
        case ir.Not():
            return not _value(e.value, names, game)
        case ir.Logic():
            found = [holds_at_start(a, names, game) for a in e.args]
            if (e.fn == "or") in found:
                return e.fn == "or"
            if None in found:
                raise NotKnown
            return e.fn == "and"
        case ir.Same():
            return bool(_value(e.left, names, game) == _value(e.right, names, game))
        case ir.Compare():
            return bool(COMPARISONS[e.fn].holds(_value(e.left, names, game), _value(e.right, names, game)))
        case ir.InRange():
            return bool(_value(e.low, names, game) <= _value(e.value, names, game) <= _value(e.high, names, game))
        case ir.InWords():
            return _value(e.value, names, game) in e.words
        case ir.Unoccupied():
            return True
        case _:
            raise NotKnown
