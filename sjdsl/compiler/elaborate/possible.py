"""Warns of what can never happen: conditions that contradict what is known where they stand, each other, or the numbers they compare."""

from collections.abc import Iterable

from sjdsl.compiler import ir
from sjdsl.compiler.ast.names import field_symbol
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.elaborate.lookup import interval_text
from sjdsl.compiler.elaborate.scope import Scope, Static
from sjdsl.compiler.ir.equivalence import form, is_exact
from sjdsl.compiler.ir.implications import Fact, Interval, conjuncts, contradict, facts, narrowed
from sjdsl.compiler.ir.printer import expression as text
from sjdsl.compiler.ir.queries import is_quantified
from sjdsl.compiler.ir.range_arithmetic import ends
from sjdsl.compiler.ir.ranges import range_of
from sjdsl.compiler.ir.types import SLACK, integer

STEP = ir.Step(type=integer(0, float("inf"), "steps"))


def know_steps(episode: ir.Expr, static: Static) -> None:
    """Keeps which numbers `step` can be: in the rules fewer than an episode has, in an observation up to that many."""
    static.rule_facts = (
        ()
        if _can_be_chosen(episode, static)
        else facts(ir.Compare(fn="<", left=STEP, right=episode))
    )
    static.observed_facts = facts(ir.Compare(fn="<=", left=STEP, right=episode))


def check_possible(test: ir.Expr, scope: Scope) -> None:
    """Warns if a condition can never hold here."""
    for part in conjuncts(test):
        why = why_impossible(part, scope)
        if why:
            warn_never(part.origin or test.span, why, scope)
            return
        scope = scope.knowing([part])


def warn_never(span: Span, problem: str, scope: Scope) -> None:
    """Warns of what can never happen, but not in checks, which may ask just that."""
    new = errors.NeverHappens(span, problem=problem)
    if scope.never is not None:
        scope.never.append(new)
    elif scope.part != "checks":
        scope.problems.add(new)


def report_never(texts: Iterable[list[list[errors.NeverHappens]]], problems: Problems) -> None:
    """Reports what is impossible in phases and defines. `texts`: of each the warnings of its uses; what one use makes possible is none."""
    for first, *others in texts:
        for new in first:
            if all(any(new.span == other.span for other in use) for use in others):
                problems.add(new)


def why_impossible(part: ir.Expr, scope: Scope) -> str:
    """Returns why a condition without `and` never holds here, empty if it may hold."""
    fact = Fact(part)
    clash = next((f for f in scope.facts if contradict(fact, f)), None)
    if clash is not None:
        return f"`{as_written(clash.condition, scope)}` holds here"
    if fact.claim.words is not None and fact.claim.subject is not None:
        known = [
            f.claim.words
            for f in scope.facts
            if f.claim.words is not None and f.subject == fact.subject
        ]
        words = fact.claim.words.intersection(*known)
        return "" if words else f"no word is left for `{as_written(fact.claim.subject, scope)}`"
    match part:
        case ir.Compare(fn=fn, left=left, right=right):
            return _why_not(fn, left, right, is_exact(part), scope)
        case ir.InRange(value=value, low=low, high=high):
            exact = is_exact(part)
            return _why_not(">=", value, low, exact, scope) or _why_not(
                "<=", value, high, exact, scope
            )
        case ir.Not(value=ir.Same(left=left, right=right)) if form(left) == form(right):
            return "both sides are the same"
        case _:
            return ""


def _why_not(fn: str, left: ir.Expr, right: ir.Expr, exact: bool, scope: Scope) -> str:
    """Returns why a comparison never holds, empty if it may hold. exact: whether whole numbers are compared, which aren't rounded."""
    if form(left) == form(right) and fn in ("<", ">", "!="):
        return "both sides are the same"
    if _can_be_chosen(left, scope.static) or _can_be_chosen(right, scope.static):
        return ""
    (low, high), (least, most) = _reach(left, scope), _reach(right, scope)
    if not exact:
        low, high = _as_float32(left, low, high)
        least, most = _as_float32(right, least, most)
    never = {
        "<": low >= most,
        "<=": low > most,
        ">": high <= least,
        ">=": high < least,
        "==": low > most or high < least,
        "!=": low == high == least == most,
    }[fn]
    if not never:
        return ""
    if isinstance(left, ir.Number) and not isinstance(right, ir.Number):
        return f"`{as_written(right, scope)}` is {interval_text(least, most)}"
    return f"`{as_written(left, scope)}` is {interval_text(low, high)}"


def as_written(e: ir.Expr, scope: Scope) -> str:
    """Returns a value as its author wrote it; a condition with `not`, or with the opposite sign, if that is what holds."""
    match e:
        case ir.Same(left=left, right=right):
            return f"{as_written(left, scope)} is {as_written(right, scope)}"
        case ir.Not(value=ir.Same(left=left, right=right)):
            return f"{as_written(left, scope)} is not {as_written(right, scope)}"
        case ir.Compare(fn=fn, left=left, right=right) if not is_quantified(e):
            return f"{as_written(left, scope)} {fn} {as_written(right, scope)}"
        case ir.Compare(left=ir.Count() as counted):
            asked = as_written(counted, scope)
            return asked if e.fn == (">" if asked.startswith("any") else "==") else f"not {asked}"
        case ir.Not(value=inner):
            return f"not {as_written(inner, scope)}"
    if e.origin is None:
        return text(e)
    source = scope.static.sources[e.origin.file].text[e.origin.start : e.origin.end]
    return f"({' '.join(source.split())})" if isinstance(e, ir.Logic) else " ".join(source.split())


def _reach(number: ir.Expr, scope: Scope) -> Interval:
    """Returns the numbers that an expression can be where a condition stands."""
    of_time = scope.static.observed_facts if scope.part == "observe" else scope.static.rule_facts
    return narrowed(number, (*of_time, *scope.facts))


def _as_float32(e: ir.Expr, low: float, high: float) -> tuple[float, float]:
    """Returns the interval of an exact number as that of a float32; what is computed is rounded more than once."""
    low_slack, high_slack = (
        (0.0, 0.0) if range_of(e).given else (SLACK * max(1.0, abs(end)) for end in (low, high))
    )
    return ends(low - low_slack, high + high_slack)


def _can_be_chosen(number: ir.Expr, static: Static) -> bool:
    """Returns whether a size or another map gives a number other limits: rules are written for all of them."""
    for node in ir.walk(number):
        match node:
            case ir.Number() if (
                node.type.unit != "number"
            ):  # literals have no other unit, sizes have no literal's
                return True
            case ir.FieldRead():
                owners = node.held_by.names or (node.held_by.name,)
                if any(field_symbol(node.name, owner) in static.sized for owner in owners):
                    return True
            case ir.Attribute(name="row" | "col" | "index") | ir.Count() | ir.Sum() | ir.Distance():
                return True
    return False
