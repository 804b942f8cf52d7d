"""Elaborates what is made of a whole row: its sum, its least and greatest entry, the key of its first entry, its shares, the row shifted."""

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.lookup import (
    as_agent,
    check_known_word,
    check_words,
    kinds_of_cell,
    or_nowhere,
)
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.ir.implications import compares, narrow_word, narrowed
from sjdsl.compiler.ir.operations import Function
from sjdsl.compiler.ir.printer import expression as text
from sjdsl.compiler.ir.types import describe, element, hull, integer, is_number, join_units, words

NO_ORDER = "agents have no order: ask for one with `where`"


def row_of_numbers(
    tree: ast.Expr, scope: Scope, wanted: str = "a row of numbers", help_: str = ""
) -> ir.Expr:
    """Returns a row of numbers, or says that `wanted` is wanted."""
    row = scope.expression(tree)
    if len(row.type.by) != 1 or row.type.kind not in ("int", "real"):
        raise wrong_type(scope, tree, wanted, row.type, help_)
    return row


def sum_of_row(row: ir.Expr, origin: Span | None = None) -> ir.SumRow:
    """Returns the sum of all entries."""
    n = len(row.type.by[0])
    type_ = row.type.model_copy(
        update={"by": (), "low": row.type.low * n, "high": row.type.high * n}
    )
    return ir.SumRow(type=beyond_one(type_), row=row, origin=origin)


def beyond_one(type_: ir.Type) -> ir.Type:
    """Returns the type of a sum: one of shares or chances that can exceed 1 is a bare number."""
    if type_.unit in ("fraction", "probability") and type_.high > 1:
        return type_.model_copy(update={"unit": "number"})
    return type_


def lowest(function: Function, e: ast.Call, scope: Scope) -> ir.Expr:
    """Returns `lowest(row)` or `highest(row)`."""
    row = row_of_numbers(e.arguments[0], scope)
    level = row.type.by[0]
    if level.sort == "agent":
        raise wrong_type(scope, e.arguments[0], "a row by words or numbers", row.type, NO_ORDER)
    type_ = (
        words(level.names)
        if level.sort == "word"
        else integer(level.first, level.first + len(level) - 1)
    )
    return ir.Lowest(type=type_, row=row, last=function.last, origin=e.span)


def mix(_: Function, e: ast.Call, scope: Scope) -> ir.Expr:
    """Returns `mix(row)`, of a row that is known not to be empty."""
    row = row_of_numbers(e.arguments[0], scope)
    if row.type.low < 0:
        raise wrong_type(scope, e.arguments[0], "a row of numbers of at least 0", row.type)
    entries = sum_of_row(row)
    if not compares(entries, ">", 0, scope.facts) and not narrowed(entries, scope.facts)[0] > 0:
        raise scope.fail(errors.EmptyMix(e.span, row=text(row)))
    return ir.Mix(type=ir.Type(kind="mix", words=row.type.by[0].names), row=row, origin=e.span)


def shifted(_: Function, e: ast.Call, scope: Scope) -> ir.Expr:
    """Returns `shift(row, n, filler)`: entries moved on by n places, the filler where none comes from."""
    row = scope.expression(e.arguments[0])
    if len(row.type.by) != 1:
        raise wrong_type(scope, e.arguments[0], "a row", row.type)
    if row.type.by[0].sort == "agent":
        raise wrong_type(scope, e.arguments[0], "a row by words or numbers", row.type, NO_ORDER)
    by = scope.fixed(e.arguments[1], "by how many places a row is shifted")
    if by != int(by):
        raise scope.fail(
            errors.WrongType(
                e.arguments[1].span, wanted="a whole number of places", actual=f"{by:g}"
            )
        )
    filler = _filler(e.arguments[2], row, scope)
    type_ = row.type
    if is_number(element(type_)):
        low, high = hull([type_, filler.type])
        type_ = type_.model_copy(
            update={
                "low": low,
                "high": high,
                "kind": "real" if "real" in (type_.kind, filler.type.kind) else "int",
            }
        )
    return ir.ShiftRow(type=type_, row=row, by=int(by), filler=filler, origin=e.span)


def _filler(tree: ast.Expr, row: ir.Expr, scope: Scope) -> ir.Expr:
    """Returns what comes in at the end of a row: of the type of its entries."""
    one = element(row.type)
    if one.kind == "word":
        check_known_word(tree, row, one.words, scope)
    filler = narrow_word(scope.expression(tree), scope.facts)
    filler = or_nowhere(filler) if one.kind == "cell" else filler
    kinds = kinds_of_cell(filler)
    fits = {
        "cell": kinds is not None and set(kinds) <= set(one.kinds),
        "int": is_number(filler.type) and filler.type.kind == "int",
        "real": is_number(filler.type),
        "word": filler.type.kind == "word" and not filler.type.by,
        "agent": as_agent(filler) and not filler.type.by,
        "agents": isinstance(filler, ir.Nobody)
        or (filler.type.kind == "agents" and not filler.type.by),
    }
    if not fits[one.kind]:
        raise wrong_type(scope, tree, describe(one), filler.type)
    check_words(filler.type.words, one.words, tree.span, row, scope)
    if is_number(one) and join_units(one.unit, filler.type.unit) is None:
        left, right = describe(one), describe(filler.type)
        raise scope.fail(
            errors.UnitMismatch(tree.span, verb="put into one row", left=left, right=right)
        )
    return filler
