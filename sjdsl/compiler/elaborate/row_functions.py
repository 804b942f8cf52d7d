"""Elaborates functions of a whole row: its sum, extremes, shares, and the row shifted."""

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.fitting import fitting_value
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.ir.implications import compares, narrowed
from sjdsl.compiler.ir.operations import Function
from sjdsl.compiler.ir.printer import expression_text as text
from sjdsl.compiler.ir.types import element, hull, integer, is_number, words

NO_ORDER = "agents have no order: ask for one with `where`"


def row_of_numbers(
    tree: ast.Expr, scope: Scope, wanted: str = "a row of numbers", help_: str = ""
) -> ir.Expr:
    """Returns a row of numbers; reports anything else. wanted, help_: texts of that message."""
    row = scope.expression(tree)
    if len(row.type.indexed_by) != 1 or row.type.kind not in ("int", "real"):
        raise wrong_type(scope, tree, wanted, row.type, help_)
    return row


def sum_of_row(row: ir.Expr, origin: Span | None = None) -> ir.SumRow:
    """Returns the sum of all entries."""
    n = len(row.type.indexed_by[0])
    low = row.type.low * n
    high = row.type.high * n
    type_ = row.type.changed(indexed_by=(), low=low, high=high)
    return ir.SumRow(type=beyond_one(type_), row=row, origin=origin)


def beyond_one(type_: ir.Type) -> ir.Type:
    """Returns the type of a sum: a sum of fractions or probabilities above 1 is a bare number."""
    if type_.unit in ("fraction", "probability") and type_.high > 1:
        return type_.changed(unit="number")
    return type_


def lowest(function: Function, e: ast.Call, scope: Scope) -> ir.Expr:
    """Returns `lowest(row)` or `highest(row)`: the first or last key whose entry is positive."""
    row = row_of_numbers(e.arguments[0], scope)
    index_set = row.type.indexed_by[0]
    match index_set.kind:
        case "agent":
            wanted = "a row by words or numbers"
            raise wrong_type(scope, e.arguments[0], wanted, row.type, NO_ORDER)
        case "word":
            type_ = words(index_set.names)
        case "number":
            type_ = integer(index_set.first, index_set.last)
    return ir.Lowest(type=type_, row=row, last=function.last, origin=e.span)


def mix(_: Function, e: ast.Call, scope: Scope) -> ir.Expr:
    """Returns `mix(row)`: each entry's share in the sum, which must be known to be positive."""
    row = row_of_numbers(e.arguments[0], scope)
    if row.type.low < 0:
        raise wrong_type(scope, e.arguments[0], "a row of numbers of at least 0", row.type)
    entries = sum_of_row(row)
    least, _most = narrowed(entries, scope.facts)
    if least <= 0 and not compares(entries, ">", 0, scope.facts):
        raise scope.fail(errors.EmptyMix(e.span, row=text(row)))
    type_ = ir.Type(kind="mix", words=row.type.indexed_by[0].names)
    return ir.Mix(type=type_, row=row, origin=e.span)


def shifted(_: Function, e: ast.Call, scope: Scope) -> ir.Expr:
    """Returns `shift(row, n, filler)`: entries moved on by n places, the filler in free ones."""
    row = scope.expression(e.arguments[0])
    if len(row.type.indexed_by) != 1:
        raise wrong_type(scope, e.arguments[0], "a row", row.type)
    if row.type.indexed_by[0].kind == "agent":
        raise wrong_type(scope, e.arguments[0], "a row by words or numbers", row.type, NO_ORDER)
    by = scope.fixed(e.arguments[1], "by how many places a row is shifted")
    if by != int(by):
        wanted = "a whole number of places"
        raise scope.expected(e.arguments[1].span, wanted, f"{by:g}")
    filler = fitting_value(e.arguments[2], row, element(row.type), scope)
    type_ = row.type
    if is_number(element(type_)):
        low, high = hull([type_, filler.type])
        kind = "real" if "real" in (type_.kind, filler.type.kind) else "int"
        type_ = type_.changed(low=low, high=high, kind=kind)
    return ir.ShiftRow(type=type_, row=row, by=int(by), filler=filler, origin=e.span)
