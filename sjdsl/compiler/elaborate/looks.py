"""Elaborates `look`: colours and sprites of cells, agents and movers; no rule depends on them."""

import re
from dataclasses import replace
from itertools import chain

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.compose import Composition
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Poisoned, Problems
from sjdsl.compiler.elaborate.possible import possible_condition
from sjdsl.compiler.elaborate.scope import Scope, Static
from sjdsl.compiler.ir.printer import expression_text as text
from sjdsl.near_names import nearest

HEXADECIMAL = re.compile("#[0-9a-fA-F]{6}")
SPRITES = (
    "tree", "apple", "water", "mushroom", "ore", "gem", "coin", "wall", "floor", "animal", "raft",
    "pot", "bush", "banana", "flag", "boat", "cart", "crate", "cube", "door", "block", "table",
    "plate",
)  # fmt: skip

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
READABLE = (
    ir.Member | ir.FieldRead | ir.At | ir.Word | ir.Number | ir.Truth | ir.Nobody | ir.Same
    | ir.Compare | ir.InRange | ir.InWords | ir.IsEmpty | ir.Not | ir.Logic | ir.SumRow | ir.Named
    | ir.Narrowed
)  # fmt: skip


def looks(game: Composition, static: Static, problems: Problems) -> tuple[ir.Look, ...]:
    """Returns the looks in the order of the file, those of one kind together.

    A field that only looks read still counts as unused.
    """
    scope = Scope(replace(static, used=set()), problems, part="look")
    written = chain.from_iterable(game.looks.values())
    return tuple(problems.each(written, lambda look: _look(look, scope)))


def _look(look: ast.Look, scope: Scope) -> ir.Look:
    """Returns a typed `look`."""
    static = scope.static
    name = look.what.text
    entity_type = static.entity_type_of(name)
    if entity_type is None:
        known = ["agent", *static.movers, *static.kinds, *static.groups]
        raise scope.problems.unknown(look.what, known, "the agents and kinds of this game")
    if name != "agent":
        static.refer(look.what, Symbol("name", name))
    test = None
    if look.where is not None:
        test = possible_condition(look.where, scope.bind_member(name, entity_type))
        for node in ir.walk(test):
            if ir.is_expression(node) and not _is_readable(node):
                span = node.origin or look.span
                raise scope.fail(errors.LookReads(span, reads=f"`{text(node)}`"))
    assert entity_type.what != "world"
    return ir.Look(
        what=entity_type.what,
        name=name,
        kinds=entity_type.names,
        condition=test,
        body=None if look.body is None else _paint(look.body, scope),
        badge=None if look.badge is None else _paint(look.badge, scope),
        origin=look.span,
    )


def _is_readable(node: ir.Expr) -> bool:
    """Returns whether a picture can show an expression: it is about one cell, agent or mover."""
    match node:
        case ir.FieldRead():
            return isinstance(node.owner, ir.Member)
        case ir.At():
            return isinstance(node.key, ir.Word | ir.Number)
        case _:
            return isinstance(node, READABLE)


def _paint(paint: ast.Paint, scope: Scope) -> ir.Paint:
    """Returns the colour and the sprite, in any order; no colour has the name of a sprite."""
    chosen: dict[str, str] = {}
    for word in paint.words:
        is_name = isinstance(word, ast.Name)
        if is_name and word.text in SPRITES:
            part = "sprite"
        elif (is_name and word.text in COLOURS) or (
            not is_name and HEXADECIMAL.fullmatch(word.text)
        ):
            part = "colour"
        else:
            raise _no_paint(word, scope)
        if part in chosen:
            raise scope.fail(errors.WrittenTwice(word.span, part=f"a {part} of one look"))
        chosen[part] = word.text
    return ir.Paint(**chosen, origin=paint.span)


def _no_paint(word: ast.Name | ast.String, scope: Scope) -> Poisoned:
    """Reports what is neither a sprite nor a colour; a name in quotes is none."""
    known = (*SPRITES, *COLOURS)
    meant = (word.text,) if word.text in known else nearest(word.text, known)
    return scope.fail(
        errors.NoPaint(
            word.span,
            name=word.text,
            nearest=meant,
            sprites=", ".join(SPRITES),
            colours=", ".join(COLOURS),
        )
    )
