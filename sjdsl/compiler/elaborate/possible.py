"""Warns of conditions that never hold: they contradict what is known, each other, or intervals."""

from collections.abc import Iterable

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import field_symbol
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.lookup import interval_text
from sjdsl.compiler.elaborate.scope import Scope, Static
from sjdsl.compiler.ir.equivalence import form, is_exact
from sjdsl.compiler.ir.implications import Fact, Interval, conjuncts, contradict, facts, narrowed
from sjdsl.compiler.ir.printer import expression_text as text
from sjdsl.compiler.ir.queries import is_any_or_all
from sjdsl.compiler.ir.range_arithmetic import ends
from sjdsl.compiler.ir.ranges import range_of
from sjdsl.compiler.ir.types import SLACK, integer

STEP = ir.Step(type=integer(0, float("inf"), "steps"))


def know_steps(episode: ir.Expr, static: Static) -> None:
    """Keeps which numbers `step` can be: in rules below the episode's length, observed up to it."""
    if not _has_other_limits(episode, static):
        static.rule_facts = facts(ir.Compare(fn="<", left=STEP, right=episode))
    static.observed_facts = facts(ir.Compare(fn="<=", left=STEP, right=episode))


def possible_condition(e: ast.Expr, scope: Scope) -> ir.Expr:
    """Returns a condition; warns if it can never hold here."""
    test = scope.condition(e)
    check_possible(test, scope)
    return test


def check_possible(test: ir.Expr, scope: Scope) -> None:
    """Warns if a condition can never hold here."""
    for part in conjuncts(test):
        reason = why_impossible(part, scope)
        if reason:
            warn_never(part.origin or test.span, reason, scope)
            return
        scope = scope.knowing([part])


def warn_never(span: Span, problem: str, scope: Scope) -> None:
    """Warns of what can never happen, but not in checks, which may be about just that."""
    warning = errors.NeverHappens(span, problem=problem)
    if scope.never is not None:
        scope.never.append(warning)
    elif scope.part != "checks":
        scope.problems.add(warning)


def report_never(
    uses_by_text: Iterable[list[list[errors.NeverHappens]]], problems: Problems
) -> None:
    """Reports what can never happen in a phase or define, whichever use of it is made.

    uses_by_text: for each phase or define, the warnings of each of its uses.
    """
    for first, *others in uses_by_text:
        spans = [{warning.span for warning in use} for use in others]
        for warning in first:
            if all(warning.span in use for use in spans):
                problems.add(warning)


def why_impossible(part: ir.Expr, scope: Scope) -> str:
    """Returns why a condition without `and` never holds here, empty if it may hold."""
    fact = Fact(part)
    for known in scope.facts:
        if contradict(fact, known):
            return f"`{as_written(known.condition, scope)}` holds here"
    if fact.claim.words is not None and fact.claim.subject is not None:
        words = fact.claim.words
        for known in scope.facts:
            if known.claim.words is not None and known.subject == fact.subject:
                words = words & known.claim.words
        return "" if words else f"no word is left for `{as_written(fact.claim.subject, scope)}`"
    match part:
        case ir.Compare(fn=fn, left=left, right=right):
            return _why_not(fn, left, right, is_exact(part), scope)
        case ir.InRange(value=value, low=low, high=high):
            exact = is_exact(part)
            too_low = _why_not(">=", value, low, exact, scope)
            return too_low or _why_not("<=", value, high, exact, scope)
        case ir.Not(value=ir.Same(left=left, right=right)) if form(left) == form(right):
            return "both sides are the same"
        case _:
            return ""


def _why_not(fn: str, left: ir.Expr, right: ir.Expr, exact: bool, scope: Scope) -> str:
    """Returns why a comparison never holds, empty if it may hold.

    exact: whether whole numbers are compared, which aren't rounded.
    """
    if form(left) == form(right) and fn in ("<", ">", "!="):
        return "both sides are the same"
    if _has_other_limits(left, scope.static) or _has_other_limits(right, scope.static):
        return ""
    low, high = _reach(left, scope)
    other_low, other_high = _reach(right, scope)
    if not exact:
        low, high = _as_float32(left, low, high)
        other_low, other_high = _as_float32(right, other_low, other_high)
    never = {
        "<": low >= other_high,
        "<=": low > other_high,
        ">": high <= other_low,
        ">=": high < other_low,
        "==": low > other_high or high < other_low,
        "!=": low == high == other_low == other_high,
    }[fn]
    if not never:
        return ""
    if isinstance(left, ir.Number) and not isinstance(right, ir.Number):
        return f"`{as_written(right, scope)}` is {interval_text(other_low, other_high)}"
    return f"`{as_written(left, scope)}` is {interval_text(low, high)}"


def as_written(e: ir.Expr, scope: Scope) -> str:
    """Returns a value as its author wrote it.

    A condition that is known to be false is written with `not`, or with the opposite sign.
    """
    match e:
        case ir.Same(left=left, right=right):
            return f"{as_written(left, scope)} is {as_written(right, scope)}"
        case ir.Not(value=ir.Same(left=left, right=right)):
            return f"{as_written(left, scope)} is not {as_written(right, scope)}"
        case ir.Compare(fn=fn, left=left, right=right) if not is_any_or_all(e):
            return f"{as_written(left, scope)} {fn} {as_written(right, scope)}"
        case ir.Compare(left=ir.Count() as counted):
            written = as_written(counted, scope)
            holds = e.fn == (">" if written.startswith("any") else "==")
            return written if holds else f"not {written}"
        case ir.Not(value=inner):
            return f"not {as_written(inner, scope)}"
    if e.origin is None:
        return text(e)
    written = scope.static.written(e.origin)
    return f"({written})" if isinstance(e, ir.Logic) else written


def _reach(number: ir.Expr, scope: Scope) -> Interval:
    """Returns the numbers that an expression can be where a condition stands."""
    static = scope.static
    about_time = static.observed_facts if scope.part == "observe" else static.rule_facts
    return narrowed(number, (*about_time, *scope.facts))


def _as_float32(e: ir.Expr, low: float, high: float) -> tuple[float, float]:
    """Returns the interval of an exact number as that of a float32.

    A computed number is rounded more than once, so its interval is widened first.
    """
    if not range_of(e).rounded_once:
        low -= SLACK * max(1.0, abs(low))
        high += SLACK * max(1.0, abs(high))
    return ends(low, high)


def _has_other_limits(number: ir.Expr, static: Static) -> bool:
    """Returns whether other sizes or another map would give a number other limits.

    Rules are written for all of these, so no warning is due.
    """
    for node in ir.walk(number):
        match node:
            case ir.Number() if node.type.unit != "number":  # a size: literals have no other unit
                return True
            case ir.FieldRead():
                owners = node.held_by.names or (node.held_by.name,)
                if any(field_symbol(node.name, owner) in static.sized for owner in owners):
                    return True
            case ir.Attribute(name="row" | "col" | "index") | ir.Distance() | ir.Bearing():
                return True
            case ir.Count() | ir.Sum():
                return True
    return False
