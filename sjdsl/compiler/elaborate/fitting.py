"""Checks that values fit the type of a field, or of the entries of a row."""

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.elaborate.lookup import (
    check_known_word,
    check_words,
    is_agent,
    kinds_of_cell,
    or_nowhere,
)
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.ir.types import describe, join_units


def fitting_value(tree: ast.Expr, owner: ir.Expr, type_: ir.Type, scope: Scope) -> ir.Expr:
    """Returns a value that fits a type, whatever its interval; reports any other.

    owner: the field, or the row, as messages call it.
    """
    if type_.kind == "word":
        check_known_word(tree, owner, type_.words, scope)
    value = scope.narrowed(tree)
    if type_.kind == "cell":
        value = or_nowhere(value)
    if value.type.indexed_by and value.type.indexed_by != type_.indexed_by:
        raise wrong_type(scope, tree, describe(type_), value.type)
    match type_.kind:
        case "word":
            if value.type.kind != "word":
                raise wrong_type(scope, tree, describe(type_), value.type)
            check_words(value.type.words, type_.words, tree.span, owner, scope)
        case "int" | "real":
            check_number(tree, type_, value, scope)
        case "agent":
            if not is_agent(value):
                raise wrong_type(scope, tree, "an agent or nobody", value.type)
        case "cell":
            _check_cell(tree, type_, value, scope)
        case "agents":
            if not isinstance(value, ir.Nobody) and value.type.kind != "agents":
                raise wrong_type(scope, tree, "a set of agents or nobody", value.type)
        case _:
            raise AssertionError(type_)
    return value


def check_number(tree: ast.Expr, type_: ir.Type, value: ir.Expr, scope: Scope) -> None:
    """Reports a value that a field of numbers can't hold.

    Such are other types than numbers, other units, and reals for whole numbers.
    """
    if value.type.kind not in ("int", "real"):
        raise wrong_type(scope, tree, describe(type_), value.type)
    if join_units(type_.unit, value.type.unit) is None:
        left = describe(type_)
        right = describe(value.type)
        raise scope.fail(
            errors.UnitMismatch(tree.span, verb="put into one field", left=left, right=right)
        )
    if type_.kind == "int" and value.type.kind != "int":
        raise wrong_type(scope, tree, "a whole number", value.type)


def _check_cell(tree: ast.Expr, type_: ir.Type, value: ir.Expr, scope: Scope) -> None:
    """Reports what isn't a cell, or a row of cells, of the kinds of a type."""
    wanted = f"{describe(type_)} or nowhere"
    kinds = value.type.kinds if value.type.kind == "cell" else kinds_of_cell(value)
    if kinds is None:
        raise wrong_type(scope, tree, wanted, value.type)
    if not set(kinds) <= set(type_.kinds):
        raise wrong_type(scope, tree, wanted, ir.Type(kind="cell", kinds=kinds))
