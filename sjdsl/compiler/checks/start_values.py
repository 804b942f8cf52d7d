"""Decides conditions as they are when an episode begins: on declared values and on the map, for given agents and cells."""

from collections.abc import Mapping
from typing import Any, NamedTuple

from sjdsl.compiler import ir
from sjdsl.compiler.ir.equivalence import is_exact
from sjdsl.compiler.ir.evaluate_constant import compares
from sjdsl.compiler.ir.operations import CALCULATIONS
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
    return [
        Place(r, c, glyph)
        for r, row in enumerate(game.rows)
        for c, glyph in enumerate(row)
        if glyph in glyphs
    ]


def holds_at_start(e: ir.Expr, names: Mapping[str, Place | int], game: ir.Game) -> bool | None:
    """Returns whether a condition holds in `phase start`; None if that is not known. `names`: the number of an agent or mover, or a cell."""
    try:
        return bool(_value(e, names, game))
    except NotKnown:
        return None


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


def _value(e: ir.Expr, names: Mapping[str, Place | int], game: ir.Game) -> Any:
    """Returns what an expression is worth. Raises NotKnown."""

    def value(part: ir.Expr) -> Any:
        return _value(part, names, game)

    who = (
        names.get(e.owner.name)
        if isinstance(e, ir.FieldRead | ir.Attribute) and isinstance(e.owner, ir.Member)
        else None
    )
    match e:
        case ir.Number() | ir.Word() | ir.Truth():
            return e.value
        case ir.Nobody():
            return None
        case ir.Step():
            return 0
        case ir.Unoccupied():
            return True
        case ir.Member() if e.name in names:
            return names[e.name]
        case ir.FieldRead() if isinstance(who, Place):
            return starts_of(game, next(g for g in game.glyphs if g.glyph == who.glyph))[e.name]
        case ir.FieldRead() if e.owner is None or who is not None:
            of_agents = (
                movers_named(game, e.held_by.name).fields
                if e.held_by.what == "mover"
                else game.agents.fields
            )
            return next(
                f.start for f in (game.fields if e.owner is None else of_agents) if f.name == e.name
            )
        case ir.Attribute(name="row" | "col") if isinstance(who, Place):
            return who.row if e.name == "row" else who.col
        case ir.Attribute(name="index") if isinstance(who, int):
            return who
        case ir.At(key=ir.Word()):  # every entry of a row begins with the same value
            return value(e.row)
        case ir.Named() | ir.Narrowed():
            return value(e.value)
        case ir.Arithmetic() if all(
            part.type.kind == "int" for part in (e, *e.args)
        ):  # reals are rounded in play
            row, values = CALCULATIONS[e.fn], [value(a) for a in e.args]
            if row.divisor is not None and not values[row.divisor]:
                raise NotKnown
            return row.fold(*values)
        case ir.Not():
            return not value(e.value)
        case ir.Logic():
            found = [holds_at_start(a, names, game) for a in e.args]
            if (e.fn == "or") in found:
                return e.fn == "or"
            if None in found:
                raise NotKnown
            return e.fn == "and"
        case ir.Same():
            return bool(value(e.left) == value(e.right))
        case ir.Compare():
            return compares(e.fn, value(e.left), value(e.right), is_exact(e))
        case ir.InRange():
            low, number, high = (value(part) for part in (e.low, e.value, e.high))
            return compares("<=", low, number, is_exact(e)) and compares(
                "<=", number, high, is_exact(e)
            )
        case ir.InWords():
            return value(e.value) in e.words
        case _:
            raise NotKnown
