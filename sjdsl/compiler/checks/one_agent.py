"""Quantifiers that only one agent passes: by its number, which a condition says or a `forbid` leaves it alone."""

from collections.abc import Iterable, Iterator, Sequence

from sjdsl.compiler import ir
from sjdsl.compiler.checks.writes import Quantifier
from sjdsl.compiler.ir.free_variables import renamed
from sjdsl.compiler.ir.implications import Fact, conjuncts, facts, narrowed
from sjdsl.compiler.ir.types import integer


def _is_lasting(node: ir.Node) -> bool:
    """Returns whether a part of a condition on an agent has one value throughout an episode: its number, and numbers of the game."""
    match node:
        case ir.Attribute():
            return node.name == "index"
        case ir.Member() | ir.ParamRef() | ir.Number() | ir.Arithmetic() | ir.Compare() | ir.InRange() | ir.Not() | ir.Logic() | ir.Named():
            return True
        case _:
            return False


def not_forbidden(condition: ir.Expr, forbids: Iterable[ir.Forbid]) -> Iterator[Fact]:
    """Yields what is known of an agent that chose an action: what holds now as it did before the step, when it was not forbidden."""
    if isinstance(condition, ir.Chose) and isinstance(condition.agent, ir.Member):
        for forbid in forbids:
            if condition.action in forbid.actions and not forbid.names:
                parts = conjuncts(renamed(forbid.condition, {"agent": condition.agent.name}), holds=False)
                yield from (fact for part in parts if all(map(_is_lasting, ir.walk(part))) for fact in facts(part))


def is_of_one_agent(quantifier: Quantifier, known: Sequence[Fact]) -> bool:
    """Returns whether all that is known leaves one agent, or one mover, to an `each`."""
    if not isinstance(quantifier.statement, ir.Each) or quantifier.statement.domain.var.sort.what == "cell":
        return False
    index = ir.Attribute(type=integer(0, float("inf"), "number"), owner=quantifier.statement.domain.var, name="index")
    low, high = narrowed(index, known)
    return low == high
