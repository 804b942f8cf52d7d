"""Finds the reals that decide something discrete: a test, a chance, what is rounded.

So do the fields and variables that these read. Their arithmetic is exact (docs/semantics.md,
section 4), which takes kernels of `sjdsl/runtime/exact_reals.py` in place of operators.
"""

from collections.abc import Iterable, Iterator

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.operations import CALCULATIONS
from sjdsl.compiler.ir.queries import written_field


class Deciding(Record):
    """The reals of a game that decide something.

    fields: by holder and name. variables: the names that `let` and `draw` give.
    """

    fields: frozenset[tuple[ir.EntityType, str]]
    variables: frozenset[str]

    def has_field(self, field: ir.FieldRead | ir.VarField) -> bool:
        """Returns whether a field that is declared, read or written decides."""
        return any(
            name == field.name and entity_type.overlaps(field.held_by)
            for entity_type, name in self.fields
        )


def deciding(game: ir.Game) -> Deciding:
    """Returns which reals decide in a game's rules, observations and metrics, not its checks.

    First those that a test, a chance or a rounding reads; then those from which statements compute
    them, and so on until there are no more.
    """
    played = game.rules.model_copy(update={"checks": ()})
    nodes = tuple(ir.walk(played))
    statements = [node for node in nodes if isinstance(node, ir.Set | ir.Add | ir.Let | ir.Draw)]
    known = _read_by(expression for node in nodes for expression in _deciding_in(node))
    while True:
        sources: list[ir.Expr] = []
        for statement in statements:
            if _is_read(statement, known):
                sources += _sources(statement)
        more = _read_by(sources)
        joined = Deciding(known.fields | more.fields, known.variables | more.variables)
        if joined == known:
            return known
        known = joined


def _deciding_in(node: ir.Node) -> Iterator[ir.Expr]:
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
    fields = set()
    variables = set()
    for expression in expressions:
        for node in ir.walk(expression):
            match node:
                case ir.FieldRead(type=ir.Type(kind="real")):
                    fields.add((node.held_by, node.name))
                case ir.Local(type=ir.Type(kind="real")):
                    variables.add(node.name)
    return Deciding(frozenset(fields), frozenset(variables))


def _is_read(statement: ir.Stmt, known: Deciding) -> bool:
    """Returns whether a statement gives a value to what decides."""
    match statement:
        case ir.Let() | ir.Draw():
            return statement.name in known.variables
        case ir.Set() | ir.Add():
            return known.has_field(written_field(statement.target))
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
