"""What guards imply: conditions split into facts, and the intervals that these leave to an expression."""

from collections.abc import Iterator
from math import ceil, floor, inf

from sjdsl.compiler import ir
from sjdsl.compiler.ir.printer import expression
from sjdsl.compiler.ir.types import interval

_MIRROR = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}
_OPPOSITE = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}


def conjuncts(condition: ir.Expr, holds: bool = True) -> Iterator[ir.Expr]:
    """Yields conditions that all hold if `condition` holds (or, with `holds` False, if it does not)."""
    match condition:
        case ir.Named():
            yield from conjuncts(condition.value, holds)
        case ir.Truth() if holds and condition.value:
            return
        case ir.Not():
            yield from conjuncts(condition.value, not holds)
        case ir.Logic() if (condition.fn == "and") == holds:
            for part in condition.args:
                yield from conjuncts(part, holds)
        case ir.Compare() if not holds:
            yield condition.model_copy(update={"fn": _OPPOSITE[condition.fn]})
        case _:
            yield condition if holds else ir.Not(value=condition, origin=condition.origin)


def fact_text(condition: ir.Expr) -> str:
    """Returns the canonical text of one condition: comparisons point to the larger side on the left."""
    if isinstance(condition, ir.Compare) and condition.fn in ("<", "<="):
        return f"({expression(condition.right)} {_MIRROR[condition.fn]} {expression(condition.left)})"
    return expression(condition)


def contradict(a: ir.Expr, b: ir.Expr) -> bool:
    """Returns whether two conditions can be seen never to hold together: opposite, other words, other ranges, other actions."""
    opposite = [fact_text(p) for p in conjuncts(b, holds=False)]
    if opposite == [fact_text(a)]:
        return True
    match a, b:
        case ir.Chose(), ir.Chose():
            return expression(a.agent) == expression(b.agent) and a.action != b.action
        case ir.StandsOn(), ir.StandsOn():
            return expression(a.agent) == expression(b.agent) and not set(a.kinds) & set(b.kinds)
        case (ir.StandsOn() as here, ir.Not(value=ir.StandsOn() as there)) | (ir.Not(value=ir.StandsOn() as there), ir.StandsOn() as here):
            return expression(here.agent) == expression(there.agent) and set(here.kinds) <= set(there.kinds)
        case ((ir.Compare() | ir.InRange()), (ir.Compare() | ir.InRange())):
            return _ranges_apart(a, b)
        case _:
            first, second = _words_allowed(a), _words_allowed(b)
            return first is not None and second is not None and first[0] == second[0] and not first[1] & second[1]


def _words_allowed(condition: ir.Expr) -> tuple[str, frozenset[str]] | None:
    """Returns (what, words it may be) for `x is w`, `x is not w`, `x in { … }`, and their negations."""
    negated = isinstance(condition, ir.Not)
    inner = condition.value if isinstance(condition, ir.Not) else condition
    match inner:
        case ir.Same(left=left, right=ir.Word(value=value)):
            words = frozenset({value})
        case ir.Same(left=ir.Word(value=value), right=left):
            words = frozenset({value})
        case ir.InWords(value=left):
            words = frozenset(inner.words)
        case _:
            return None
    if left.type.kind != "word":
        return None
    return expression(left), frozenset(left.type.words) - words if negated else words


def _bounds(condition: ir.Expr) -> tuple[str, float, float] | None:
    """Returns (what, low, high) for a comparison of an expression with a number."""
    match condition:
        case ir.InRange(value=value, low=ir.Number(value=low), high=ir.Number(value=high)):
            return expression(value), low, high
        case ir.Compare(fn=fn, left=left, right=ir.Number(value=value)):
            pass
        case ir.Compare(fn=fn, left=ir.Number(value=value), right=left):
            fn = _MIRROR[fn]
        case _:
            return None
    whole = left.type.kind == "int"
    limits = {
        "==": (value, value),
        "<=": (-inf, floor(value) if whole else value),
        ">=": (ceil(value) if whole else value, inf),
        "<": (-inf, ceil(value) - 1 if whole else value),
        ">": (floor(value) + 1 if whole else value, inf),
    }
    return (expression(left), *limits[fn]) if fn in limits else None


def at_least(text: str, facts: tuple[ir.Expr, ...]) -> float:
    """Returns the largest number that the facts put below an expression, given as its text."""
    return max((bounds[1] for fact in facts if (bounds := _bounds(fact)) is not None and bounds[0] == text), default=-inf)


def _ranges_apart(a: ir.Expr, b: ir.Expr) -> bool:
    first, second = _bounds(a), _bounds(b)
    if first is None or second is None or first[0] != second[0]:
        return False
    return first[2] < second[1] or second[2] < first[1]


def narrow_word(e: ir.Expr, facts: tuple[ir.Expr, ...]) -> ir.Expr:
    """Returns a word without the words that the facts about that very expression exclude."""
    if e.type.kind != "word" or e.type.by or isinstance(e, ir.Word):
        return e
    text, left = expression(e), frozenset(e.type.words)
    for fact in facts:
        allowed = _words_allowed(fact)
        if allowed is not None and allowed[0] == text:
            left &= allowed[1]
    if not left or left == frozenset(e.type.words):
        return e
    words = tuple(w for w in e.type.words if w in left)
    return ir.Narrowed(type=ir.Type(kind="word", words=words), value=e, origin=e.origin)


def narrowed(e: ir.Expr, facts: tuple[ir.Expr, ...]) -> tuple[float, float]:
    """Returns the interval of a number once the facts about it, or about its parts, are used."""
    low, high = e.type.low, e.type.high
    if isinstance(e, ir.Arithmetic) and not e.type.by:
        by_parts = _of_parts(e, [narrowed(a, facts) for a in e.args])
        low, high = max(low, by_parts[0]), min(high, by_parts[1])
    elif isinstance(e, ir.Named):
        low, high = narrowed(e.value, facts)
    text = expression(e)
    for fact in facts:
        bounds = _bounds(fact)
        if bounds is not None and bounds[0] == text:
            low, high = max(low, bounds[1]), min(high, bounds[2])
        match fact:
            case ir.Compare(fn=("<" | "<=") as fn, left=left, right=right) if expression(left) == text and right.type.kind == "int":
                high = min(high, right.type.high - (fn == "<"))
            case ir.Compare(fn=(">" | ">=") as fn, left=left, right=right) if expression(left) == text and right.type.kind == "int":
                low = max(low, right.type.low + (fn == ">"))
    return low, high


def _of_parts(e: ir.Arithmetic, parts: list[tuple[float, float]]) -> tuple[float, float]:
    """Returns the interval of an operation from those of its operands."""
    match e.fn:
        case "neg":
            return -parts[0][1], -parts[0][0]
        case "min":
            return min(p[0] for p in parts), min(p[1] for p in parts)
        case "max":
            return max(p[0] for p in parts), max(p[1] for p in parts)
        case _:
            left, right = (a.type.model_copy(update={"low": p[0], "high": p[1]}) for a, p in zip(e.args, parts, strict=True))
            return interval(e.fn, left, right)
