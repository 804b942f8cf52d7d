"""Elaborates `case`: every value of the subject has exactly one arm (exhaustiveness)."""

from itertools import chain
from math import inf, isfinite
from typing import NamedTuple

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ast.names import Symbol
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Poisoned
from sjdsl.compiler.elaborate.arithmetic import join_types
from sjdsl.compiler.elaborate.lookup import not_among
from sjdsl.compiler.elaborate.scope import Scope, wrong_type
from sjdsl.compiler.ir.implications import narrowed


class Range(NamedTuple):
    """Values of a subject: the numbers from `low` to `high` (None: without an end), or words."""

    low: int | None = None
    high: int | None = None
    words: tuple[str, ...] = ()


Key = list[Range]  # the values of an arm; none for `otherwise`, until what is left is known


def case(e: ast.Case, scope: Scope) -> ir.Expr:
    """Returns a `case` whose arms cover the subject once; `otherwise` is spelt out."""
    subject = scope.narrowed(e.subject)
    if isinstance(subject, ir.Word):
        return _known_word(e, subject, scope)
    if subject.type.is_single("word", "condition"):
        keys = _word_keys(e, subject, scope)
    elif subject.type.is_single("int"):
        keys = _number_keys(e, subject, scope)
    else:
        wanted = "a whole number, a word or a condition"
        raise wrong_type(scope, e.subject, wanted, subject.type)

    def arms_of(arm_and_key: tuple[ast.Arm, Key]) -> list[ir.Arm]:
        """Returns the typed arms of one written arm: `otherwise` can stand for several ranges."""
        arm, key = arm_and_key
        inner = scope
        if subject.type.kind == "condition" and len(key) == 1:
            holds = key[0].words == ("yes",)
            inner = scope.knowing([subject if holds else ir.Not(value=subject)])
        value = inner.expression(arm.value)
        return [ir.Arm(**part._asdict(), value=value, origin=arm.span) for part in key]

    built = scope.problems.each(zip(e.arms, keys, strict=True), arms_of)
    if len(built) < len(e.arms):
        raise Poisoned
    arms = tuple(chain.from_iterable(built))
    type_ = join_types([a.value.type for a in arms], scope, "choose between", e)
    return ir.Case(type=type_, subject=subject, arms=arms, origin=e.span)


def _known_word(e: ast.Case, subject: ir.Word, scope: Scope) -> ir.Expr:
    """Returns the arm of a word known when compiled, a phase's argument; checks the other arms."""
    chosen: ir.Expr | None = None
    otherwise: ir.Expr | None = None
    for arm in e.arms:
        if arm.word is not None and not scope.static.is_word(arm.word.text):
            raise not_among(arm.word, (subject.value,), "this case", scope)
        value = scope.expression(arm.value)
        if arm.word is None:
            otherwise = value
            continue
        scope.static.refer(arm.word, Symbol("word", arm.word.text))
        if arm.word.text == subject.value:
            chosen = value
    result = chosen or otherwise
    if result is None:
        raise scope.fail(errors.CaseLacks(e.span, words=(subject.value,)))
    return result


def _word_keys(e: ast.Case, subject: ir.Expr, scope: Scope) -> list[Key]:
    """Returns the words of each arm; none for `otherwise`, which the caller fills."""
    names = ("yes", "no") if subject.type.kind == "condition" else subject.type.words
    seen: set[str] = set()
    keys: list[Key] = []
    for arm in e.arms:
        if arm.low is not None:
            raise scope.fail(errors.NumberForWord(arm.span))
        if arm.word is None:
            keys.append([])
            continue
        word = arm.word.text
        if word not in names:
            raise not_among(arm.word, names, "this case", scope)
        if word in seen:
            raise scope.fail(errors.CaseRepeats(arm.word.span, name=word))
        seen.add(word)
        if subject.type.kind == "word":
            scope.static.refer(arm.word, Symbol("word", word))
        keys.append([Range(words=(word,))])
    unseen = tuple(name for name in names if name not in seen)
    rest = [Range(words=unseen)] if unseen else []
    _close(e, keys, rest, errors.CaseLacks(e.span, words=unseen), scope)
    return keys


def _number_keys(e: ast.Case, subject: ir.Expr, scope: Scope) -> list[Key]:
    """Returns the ranges of each arm; none for `otherwise`, which the caller fills."""
    taken: list[tuple[float, float]] = []
    keys: list[Key] = []
    for arm in e.arms:
        if arm.word is not None:
            raise scope.fail(errors.WordForNumber(arm.span, name=arm.word.text))
        if arm.low is None:
            keys.append([])
            continue
        last = arm.low if arm.high is None else arm.high
        end = inf if arm.open else last
        if last < arm.low or any(first <= end and arm.low <= other for first, other in taken):
            raise scope.fail(errors.CaseOverlaps(arm.span))
        taken.append((arm.low, end))
        keys.append([Range(arm.low, None if arm.open else last)])
    low, high = narrowed(subject, scope.facts)
    gaps = _gaps(taken, low, high)
    rest = [Range(_whole(first), _whole(last)) for first, last in gaps]
    _close(e, keys, rest, errors.CaseLeavesOpen(e.span, numbers=_first_gap(rest)), scope)
    return keys


def _gaps(taken: list[tuple[float, float]], low: float, high: float) -> list[tuple[float, float]]:
    """Returns the intervals of whole numbers from `low` to `high` that no interval covers."""
    gaps = []
    reached = low
    for first, last in sorted(taken):
        if first > reached:
            gaps.append((reached, min(first - 1, high)))
        reached = max(reached, last + 1)
    if reached <= high and reached < inf:
        gaps.append((reached, high))
    return [(first, last) for first, last in gaps if first <= last]


def _whole(end: float) -> int | None:
    return int(end) if isfinite(end) else None


def _first_gap(gaps: Key) -> str:
    """Returns the first gap as the key of an arm is written, empty if there is none."""
    if not gaps:
        return ""
    low, high, _ = gaps[0]
    if low is not None and low == high:
        return f"{low}"
    return f"{'' if low is None else low}..{'' if high is None else high}"


def _close(e: ast.Case, keys: list[Key], rest: Key, lacking: errors.TableGap, scope: Scope) -> None:
    """Gives the values that are left to the arm `otherwise`, by changing the last of `keys`.

    Reports an `otherwise` that isn't the last arm or that nothing is left for. Without one, it
    reports `lacking` if something is left.

    Args:
      keys: of each arm its values, none for `otherwise`. rest: the values that are left.
    """
    open_arms = [arm for arm, key in zip(e.arms, keys, strict=True) if not key]
    if not open_arms:
        if rest:
            raise scope.fail(lacking)
        return
    if open_arms != [e.arms[-1]]:
        raise scope.fail(errors.OtherwiseNotLast(open_arms[0].span))
    if not rest:
        raise scope.fail(errors.NothingForOtherwise(e.arms[-1].span))
    keys[-1] = rest
