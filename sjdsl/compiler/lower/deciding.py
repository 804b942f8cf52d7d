"""Which reals decide something discrete: a test, a chance, what is rounded; and so do the fields and variables that these read.

Their arithmetic is exact (docs/semantics.md, section 4), which takes kernels of `sjdsl/runtime/exact_reals.py` in place of operators.
"""

from collections.abc import Iterable, Iterator

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.operations import CALCULATIONS
from sjdsl.compiler.ir.queries import written_field


class Deciding(Record):
    """What of a game decides. fields: by holder and name; variables: the names that `let` and `draw` give."""

    fields: frozenset[tuple[ir.Sort, str]]
    variables: frozenset[str]

    def has_field(self, field: ir.FieldRead | ir.VarField) -> bool:
        """Returns whether a field that is declared, read or written decides."""
        return any(
            name == field.name and sort.overlaps(field.held_by) for sort, name in self.fields
        )


def deciding(game: ir.Game) -> Deciding:
    """Returns what of a game's rules, observations and metrics decides; its checks are no part of the play."""
    played = game.rules.model_copy(update={"checks": ()})
    nodes = tuple(ir.walk(played))
    statements = [node for node in nodes if isinstance(node, ir.Set | ir.Add | ir.Let | ir.Draw)]
    found = _read_by(root for node in nodes for root in _roots(node))
    while True:
        more = _read_by(
            source
            for statement in statements
            if _is_read(statement, found)
            for source in _sources(statement)
        )
        joined = Deciding(found.fields | more.fields, found.variables | more.variables)
        if joined == found:
            return found
        found = joined


def _roots(node: ir.Node) -> Iterator[ir.Expr]:
    """Yields the expressions of a node whose values decide."""
    match node:
        case ir.Compare():
            yield from (node.left, node.right)
        case ir.InRange():
            yield from (node.value, node.low, node.high)
        case ir.Arithmetic() if CALCULATIONS[node.fn].kind == "whole":
            yield from node.args
        case ir.Lowest():
            yield node.row
        case ir.Chance():
            yield from (branch.test for branch in node.branches)
        case ir.Draw():
            yield from node.weights


def _read_by(expressions: Iterable[ir.Expr]) -> Deciding:
    """Returns the reals that expressions read."""
    nodes = [node for expression in expressions for node in ir.walk(expression)]
    fields = (
        (node.held_by, node.name)
        for node in nodes
        if isinstance(node, ir.FieldRead) and node.type.kind == "real"
    )
    variables = (
        node.name for node in nodes if isinstance(node, ir.Local) and node.type.kind == "real"
    )
    return Deciding(frozenset(fields), frozenset(variables))


def _is_read(statement: ir.Stmt, found: Deciding) -> bool:
    match statement:
        case ir.Let() | ir.Draw():
            return statement.name in found.variables
        case ir.Set() | ir.Add():
            return found.has_field(written_field(statement.target))
        case _:
            return False


def _sources(statement: ir.Stmt) -> Iterator[ir.Expr]:
    """Yields the expressions that a statement makes a value of."""
    match statement:
        case ir.Let() | ir.Set() | ir.Add():
            yield statement.value
        case ir.Draw(low=ir.Expression() as low, high=ir.Expression() as high):
            yield from (low, high)
        case _:
            pass
