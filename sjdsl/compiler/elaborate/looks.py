"""Elaborates `look`: colours and sprites of cells, agents and movers; no rule depends on them."""

import re
from dataclasses import replace
from typing import Literal

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import near
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.elaborate.possible import check_possible
from sjdsl.compiler.elaborate.scope import Scope, Static
from sjdsl.compiler.ir.printer import expression as text
from sjdsl.near_names import nearest

HEXADECIMAL = re.compile("#[0-9a-fA-F]{6}")
SPRITES = (
    *(
        "tree",
        "apple",
        "water",
        "mushroom",
        "ore",
        "gem",
        "coin",
        "wall",
        "floor",
        "animal",
        "raft",
        "pot",
    ),
    *("bush", "banana", "flag", "boat", "cart", "crate", "cube", "door", "block", "table", "plate"),
)

# The colours a file can name. Those after grey are Okabe and Ito's (2008, "Color universal design"), which people with any kind of
# colour vision can tell apart, or darker and paler ones between them.
COLOURS: dict[str, str] = {
    "white": "#f7f7f5",
    "grey": "#8b9098",
    "black": "#33373d",
    "red": "#c8321e",
    "orange": "#e69f00",
    "yellow": "#f0e442",
    "green": "#009e73",
    "sky": "#56b4e9",
    "blue": "#0072b2",
    "purple": "#6a3d9a",
    "pink": "#cc79a7",
    "brown": "#8c5a2b",
}
READABLE = (  # what the condition of a look may be made of: a picture is drawn from the fields of a cell, an agent or a mover alone
    ir.Member | ir.FieldRead | ir.At | ir.Word | ir.Number | ir.Truth | ir.Nobody | ir.Same | ir.Compare | ir.InRange | ir.InWords
    | ir.IsEmpty | ir.Not | ir.Logic | ir.SumRow | ir.Named | ir.Narrowed
)  # fmt: skip


def looks(game: Composition, static: Static, problems: Problems) -> tuple[ir.Look, ...]:
    """Returns the looks in the order of the file, those of one kind together; what only they read still counts as unused."""
    written = (look for alike in game.looks.values() for look in alike)
    return tuple(
        problems.each(
            written,
            lambda look: _look(look, Scope(replace(static, used=set()), problems, part="look")),
        )
    )


def _look(look: ast.Look, scope: Scope) -> ir.Look:
    name, static = look.what.text, scope.static
    kinds = () if name == "agent" else (name,) if name in static.movers else static.kinds_of(name)
    if kinds is None:
        meant = near(name, ["agent", *static.kinds, *static.groups, *static.movers])
        raise scope.fail(errors.UnknownName(look.what.span, name=name, near=meant))
    if name != "agent":
        static.refer(look.what, Symbol("name", name))
    what: Literal["agent", "cell", "mover"] = (
        "agent" if name == "agent" else "mover" if name in static.movers else "cell"
    )
    test = None
    if look.where is not None:
        inner = scope.bind(name, ir.Member(name=name, sort=ir.Sort(what, kinds)))
        test = inner.condition(look.where)
        check_possible(test, inner)
        for node in ir.walk(test):
            field_of_other = isinstance(node, ir.FieldRead) and not isinstance(
                node.owner, ir.Member
            )
            between_cells = isinstance(node, ir.At) and not isinstance(
                node.key, ir.Word | ir.Number
            )
            if ir.is_expression(node) and (
                not isinstance(node, READABLE) or field_of_other or between_cells
            ):
                raise scope.fail(
                    errors.LookReads(node.origin or look.span, reads=f"`{text(node)}`")
                )
    body, badge = (
        None if paint is None else _paint(paint, scope) for paint in (look.body, look.badge)
    )
    return ir.Look(
        what=what, name=name, kinds=kinds, condition=test, body=body, badge=badge, origin=look.span
    )


def _paint(paint: ast.Paint, scope: Scope) -> ir.Paint:
    """Returns the colour and the sprite; their names have none in common, so that their order is free."""
    chosen: dict[str, str] = {}
    for word in paint.words:
        sort = "sprite" if isinstance(word, ast.Name) and word.text in SPRITES else "colour"
        is_colour = (
            word.text in COLOURS if isinstance(word, ast.Name) else HEXADECIMAL.fullmatch(word.text)
        )
        if sort == "colour" and not is_colour:
            known = (*SPRITES, *COLOURS)
            meant = (
                (word.text,) if word.text in known else nearest(word.text, known)
            )  # a name in quotes is no colour
            sprites, colours = ", ".join(SPRITES), ", ".join(COLOURS)
            raise scope.fail(
                errors.NoPaint(
                    word.span, name=word.text, nearest=meant, sprites=sprites, colours=colours
                )
            )
        if sort in chosen:
            raise scope.fail(errors.WrittenTwice(word.span, part=f"a {sort} of one look"))
        chosen[sort] = word.text
    return ir.Paint(**chosen, origin=paint.span)
