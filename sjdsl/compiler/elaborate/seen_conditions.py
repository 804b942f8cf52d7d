"""Conditions of `show` and `hide`: what they may name, and that they ask for no place of an agent that may be away."""

from collections.abc import Iterable

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.elaborate.scope import Scope, Static
from sjdsl.compiler.ir.implications import Fact, facts, is_known


def observer_scope(what: str, kind: str, named: str, static: Static, problems: Problems) -> Scope:
    """Returns what conditions may name: `agent`, the observer, and the cell or agent that is seen. `named`: a group that a cell is called by."""
    scope = Scope(static, problems, facts=static.of_observed, part="observe").bind("agent", ir.Member(name="agent", sort=ir.Sort("agent")))
    if what == "cell":
        cell = ir.Member(name=kind, sort=ir.Sort("cell", (kind,)))
        return scope.bind(kind, cell).bind(named, cell)
    if what == "mover":
        return scope.bind(kind, ir.Member(name=kind, sort=ir.Sort("mover", (kind,))))
    if what in ("other", "heading"):
        return scope.bind("other", ir.Member(name="other", sort=ir.Sort("agent")))
    if what == "everyone":
        return scope.bind("everyone", ir.Member(name="everyone", sort=ir.Sort("agent")))
    return scope


def joined(tests: list[ir.Expr]) -> ir.Expr:
    """Returns the condition that one of some conditions holds."""
    return tests[0] if len(tests) == 1 else ir.Logic(fn="or", args=tuple(tests), origin=tests[-1].origin)


def check_places(what: str, test: ir.Expr | None, known: Iterable[Fact], static: Static, problems: Problems) -> None:
    """Reports a condition that asks where an agent of `everyone` is, who may be away. `known`: what holds where it is asked."""
    if test is None or what != "everyone" or not static.can_be_away:
        return
    asked = next((node for node in ir.walk(test) if _asks_place(node)), None)
    everyone = ir.Member(name="everyone", sort=ir.Sort("agent"))
    away = ir.Attribute(type=ir.CONDITION, owner=everyone, name="away")
    first = test.args[0] if isinstance(test, ir.Logic) and test.fn == "and" else None
    sure = (*known, *(facts(first) if first is not None and not any(map(_asks_place, ir.walk(first))) else ()))
    if asked is not None and not is_known(ir.Not(value=away), sure):
        help_ = (
            "ask that first: `as { gone where everyone.away, near where distance(agent, everyone) < 3, far }`, or `not everyone.away and …`"
        )
        raise problems.fail(
            errors.Unsupported(asked.origin or test.origin, what="the place of an agent of `everyone`, who may be away", help=help_)  # type: ignore[arg-type]
        )


def _asks_place(node: ir.Node) -> bool:
    match node:
        case ir.Attribute(owner=ir.Member(name="everyone"), name="row" | "col"):
            return True
        case ir.Distance():
            return any(isinstance(place, ir.Member) and place.name == "everyone" for place in (node.left, node.right))
        case _:
            return False
