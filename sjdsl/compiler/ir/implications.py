"""What guards imply.

Conditions split into facts, and the intervals and words that these leave to an expression.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import ceil, floor, inf, isinf
from typing import ClassVar, NamedTuple

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.equivalence import NONE, Form, Memo, Names, form, is_exact
from sjdsl.compiler.ir.fold import BOUNDS, Analysis, fold
from sjdsl.compiler.ir.linear import Linear, linear, narrowed_sum, not_negative
from sjdsl.compiler.ir.operations import CALCULATIONS, COMPARISONS
from sjdsl.compiler.ir.range_arithmetic import Range, ends
from sjdsl.compiler.ir.ranges import FloatRanges, are_numbers, range_of
from sjdsl.compiler.ir.values import TOLERANCE

STEP = 2.0**-23  # from a float32 to the next one, relative; at most
# By how much a real may pass the number that a `require` compares it with, relative.
LOOSE = 2 * TOLERANCE


def conjuncts(condition: ir.Expr, holds: bool = True) -> Iterator[ir.Expr]:
    """Yields conditions that all hold if `condition` holds.

    Where a real may be NaN, with which no comparison holds, a comparison that does not hold stays
    one: `not x > y`.

    Args:
      holds: False if it is known not to hold.
    """
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
        case ir.Compare() if not holds and are_numbers(condition.left, condition.right):
            yield _opposite(condition)
        case _:
            yield condition if holds else ir.Not(value=condition, origin=condition.origin)


def _opposite(comparison: ir.Compare) -> ir.Compare:
    """Returns the comparison that holds where this one doesn't, of numbers."""
    return comparison.changed(fn=COMPARISONS[comparison.fn].opposite)


def without_nan(condition: ir.Expr) -> ir.Expr:
    """Returns what a condition says of numbers: `x <= y` for `not x > y`."""
    match condition:
        case ir.Not(value=ir.Compare() as comparison):
            return _opposite(comparison)
        case _:
            return condition


Interval = tuple[float, float]


class Fact(Record, eq=False):
    """One condition that holds, and what it says of its subject.

    Of a number an interval, of a word those it may be.

    `names`: what stands for free variables, as in `form`; two facts are compared under the same
    names.
    """

    condition: ir.Expr
    names: Names = field(default_factory=dict)

    @cached_property
    def form(self) -> Form:
        return _directed(self.condition, self.names)

    @cached_property
    def form_without_nan(self) -> Form:
        return _directed(without_nan(self.condition), self.names)

    @cached_property
    def excluded(self) -> tuple[Form, ...]:
        """What can't hold beside the fact, as far as one condition says it."""
        excluded = list(conjuncts(self.condition, holds=False))
        if len(excluded) != 1:
            return ()
        return tuple(
            _directed(condition, self.names)
            for condition in (excluded[0], without_nan(excluded[0]))
        )

    @cached_property
    def subject(self) -> Form | None:
        return None if self.claim.subject is None else form(self.claim.subject, self.names)

    @cached_property
    def claim(self) -> "Claim":
        return _claim(self.condition)

    @cached_property
    def not_negative(self) -> tuple[Linear, ...]:
        """The sums of which the fact says that they are at least 0."""
        return tuple(not_negative(without_nan(self.condition)))

    @cached_property
    def is_exact(self) -> bool:
        return is_exact(without_nan(self.condition))


def facts(condition: ir.Expr, holds: bool = True) -> tuple[Fact, ...]:
    """Returns what is known if a condition holds (or, with `holds` False, if it does not)."""
    known: list[Fact] = []
    for part in conjuncts(condition, holds):
        known += [Fact(part), *map(Fact, _arguments_known(part))]
    return tuple(known)


def _arguments_known(condition: ir.Expr) -> Iterator[ir.Expr]:
    """Yields what else holds of an action that was chosen with known arguments.

    That it was chosen, and what each of them is.
    """
    if not isinstance(condition, ir.ChoseWith) or not condition.given:
        return
    yield condition.changed(given=())
    for number, given in enumerate(condition.given):
        argument = ir.ArgumentOf(
            type=given.type,
            agent=condition.agent,
            action=condition.action,
            number=number,
            name=given.name,
        )
        if given.type.kind == "int":
            yield ir.Compare(fn="==", left=argument, right=given.value)
        elif given.type.kind == "word":
            yield ir.Same(left=argument, right=given.value)


def is_known(condition: ir.Expr, known: Iterable[Fact]) -> bool:
    """Returns whether a condition is one of the facts.

    Of a comparison, also where a real in it is NaN.
    """
    wanted = _directed(condition)
    return any(wanted in (f.form, f.form_without_nan) for f in known)


def compares(
    left: ir.Expr, fn: ir.Comparison, right: ir.Expr | float, known: Iterable[Fact]
) -> bool:
    """Returns whether a comparison is one of the facts."""
    right = right if isinstance(right, ir.Node) else ir.Number(type=left.type, value=right)
    return is_known(ir.Compare(fn=fn, left=left, right=right), known)


def _directed(condition: ir.Expr, names: Names = NONE) -> Form:
    """Returns the form of a condition; `a < b` has that of `b > a`."""
    if isinstance(condition, ir.Compare) and condition.fn in ("<", "<="):
        mirrored = {
            "fn": COMPARISONS[condition.fn].mirror,
            "left": condition.right,
            "right": condition.left,
        }
        condition = condition.changed(**mirrored)
    return form(condition, names)


def contradict(a: Fact, b: Fact) -> bool:
    """Returns whether two facts can be seen never to hold together.

    They are opposite, or name other enum values, ranges or actions.
    """
    if a.form in b.excluded:
        return True
    if a.subject is None or a.subject != b.subject:
        return False
    match a.condition, b.condition:
        case ir.Chose(action=one), ir.Chose(action=other):
            return one != other
        case (ir.Chose(), ir.ChoseWith()) | (ir.ChoseWith(), ir.Chose()):
            return True
        case ir.ChoseWith() as one, ir.ChoseWith() as other:
            return one.action != other.action or _have_other_arguments(one, other)
        case ir.StandsOn() as here, ir.StandsOn() as there:
            return not set(here.kinds) & set(there.kinds)
        case (ir.StandsOn() as here, ir.Not(value=ir.StandsOn() as there)) | (
            ir.Not(value=ir.StandsOn() as there),
            ir.StandsOn() as here,
        ):
            return set(here.kinds) <= set(there.kinds)
    if a.claim.interval is not None and b.claim.interval is not None:
        return not (_admits_nan(a) and _admits_nan(b)) and _are_disjoint(a.claim, b.claim)
    if a.claim.words is None or b.claim.words is None:
        return False
    return a.claim.words.isdisjoint(b.claim.words)


def _have_other_arguments(one: ir.ChoseWith, other: ir.ChoseWith) -> bool:
    """Returns whether two choices of one action differ in an argument that is written out."""
    if not (one.given and other.given):
        return False
    for first, second in zip(one.given, other.given, strict=True):
        a = first.value
        b = second.value
        if isinstance(a, ir.Number | ir.Word) and isinstance(b, type(a)) and a.value != b.value:
            return True
    return False


def _admits_nan(fact: Fact) -> bool:
    """Returns whether a fact that compares numbers also holds of NaN."""
    return isinstance(fact.condition, ir.Not)


def _are_disjoint(a: "Claim", b: "Claim") -> bool:
    """Returns whether no number is in the intervals of both claims.

    What a real is compared with is rounded to float32.
    """
    assert a.subject is not None
    assert a.interval is not None
    assert b.interval is not None
    a_low, a_high = a.interval
    b_low, b_high = b.interval
    if a.subject.type.kind == "real":
        a_low, a_high = ends(a_low, a_high)
        b_low, b_high = ends(b_low, b_high)
    return a_high < b_low or b_high < a_low


class Claim(NamedTuple):
    """What a condition says of one expression, unless that is NaN.

    interval: by a comparison with a number; reach: by one with something else, from its type.
    """

    subject: ir.Expr | None = None
    interval: Interval | None = None
    reach: Interval | None = None
    words: frozenset[str] | None = None


def _claim(condition: ir.Expr) -> Claim:
    """Returns what a condition says of one expression; an empty claim if it says nothing."""
    exact = is_exact(without_nan(condition))
    match without_nan(condition):
        case (
            ir.Chose(agent=agent)
            | ir.ChoseWith(agent=agent)
            | ir.StandsOn(agent=agent)
            | ir.Not(value=ir.StandsOn(agent=agent))
        ):
            return Claim(agent)
        case ir.Not(value=inner):
            words, subject = _words_named(inner)
            if subject is None:
                return Claim()
            return Claim(subject, words=frozenset(subject.type.words) - words)
        case ir.InRange(value=subject, low=ir.Number(value=low), high=ir.Number(value=high)):
            return Claim(subject, limits_of("==", subject, (low, high), exact))
        case ir.Compare(fn=fn, left=subject, right=ir.Number(value=value)):
            return Claim(subject, limits_of(fn, subject, (value, value), exact))
        case ir.Compare(fn=fn, left=ir.Number(value=value), right=subject):
            return Claim(subject, limits_of(COMPARISONS[fn].mirror, subject, (value, value), exact))
        case ir.Compare(fn="<" | "<=" | ">" | ">=" as fn, left=subject, right=right) if (
            right.type.kind == "int"
        ):
            return Claim(subject, reach=limits_of(fn, subject, (right.type.low, right.type.high)))
        case _:
            words, subject = _words_named(condition)
            return Claim(subject, words=words)


def _words_named(condition: ir.Expr) -> tuple[frozenset[str], ir.Expr | None]:
    """Returns {a, b} and x for `x in { a, b }`, and for `x is a or x is b`: x is one of these.

    No values and None for a condition of another form.
    """
    match condition:
        case ir.Named(value=value):
            return _words_named(value)
        case ir.Logic(fn="or", args=args):
            sets, subjects = zip(*map(_words_named, args), strict=True)
            if any(x is None or form(x) != form(subjects[0]) for x in subjects):
                return frozenset(), None
            return frozenset().union(*sets), subjects[0]
        case (
            ir.Same(left=subject, right=ir.Word(value=value))
            | ir.Same(left=ir.Word(value=value), right=subject)
        ):
            words = frozenset({value})
        case ir.InWords(value=subject):
            words = frozenset(condition.words)
        case _:
            return frozenset(), None
    return (words, subject) if subject.type.kind == "word" else (frozenset(), None)


def limits_of(fn: str, subject: ir.Expr, other: Interval, exact: bool = True) -> Interval | None:
    """Returns the interval of a number that compares so with one in another interval.

    exact: whether whole numbers are compared; otherwise both are rounded to float32, so that a
    whole number may be beyond its equal.
    """
    low, high = other
    whole = subject.type.kind == "int"
    if whole and not exact:
        low, high = ends(low, high)
        if fn in ("<=", ">=", "=="):
            low -= STEP * abs(low)
            high += STEP * abs(high)
    least = above = low
    most = below = high
    if whole and not isinf(low):
        least = ceil(low)
        above = floor(low) + 1
    if whole and not isinf(high):
        most = floor(high)
        below = ceil(high) - 1
    match fn:
        case "==":
            return least, most
        case "<=":
            return -inf, most
        case ">=":
            return least, inf
        case "<":
            return -inf, below
        case ">":
            return above, inf
        case _:
            return None


def narrow_word(e: ir.Expr, known: Iterable[Fact]) -> ir.Expr:
    """Returns a word without the words that the facts about that very expression exclude."""
    if not e.type.is_single("word") or isinstance(e, ir.Word):
        return e
    subject = form(e)
    possible = frozenset(e.type.words)
    for fact in known:
        if fact.claim.words is not None and fact.subject == subject:
            possible &= fact.claim.words
    if not possible or possible == frozenset(e.type.words):
        return e
    words = tuple(word for word in e.type.words if word in possible)
    return ir.Narrowed(type=ir.Type(kind="word", words=words), value=e, origin=e.origin)


def narrowed_real(e: ir.Expr, known: Sequence[Fact], loose: bool = True) -> tuple[float, float]:
    """Returns the interval of a number as it is computed in float32.

    The facts about it and about its parts are used.

    loose: whether a real may pass the ends that facts name, by `LOOSE`.
    """

    def limits(part: ir.Expr) -> Interval:
        low, high = _claimed(form(part), known)
        if part.type.kind == "int":
            return low, high
        return _loosened(low, high) if loose else ends(low, high)

    computed = range_of(e, limits)
    return computed.low, computed.high


def computed_range(
    e: ir.Expr,
    known: Sequence[Fact],
    required: Sequence[Fact],
    variables: Mapping[str, Range],
) -> Range:
    """Returns the range of a number that is kept, as it is computed in float32.

    Args:
      known: facts from guards; these hold exactly of what is kept in fields and variables, whose
        reals then decide, and up to rounding of what is computed of them.
      required: facts from `require`s, which are tested up to a tolerance.
      variables: the ranges of reals that `let` and `draw` name.
    """

    def limits(part: ir.Expr) -> Interval:
        subject = form(part)
        low, high = _claimed(subject, known)
        required_low, required_high = _claimed(subject, required)
        if part.type.kind == "int":
            return max(low, required_low), min(high, required_high)
        low, high = ends(low, high) if _is_kept(part) else _loosened(low, high)
        required_low, required_high = _loosened(required_low, required_high)
        return max(low, required_low), min(high, required_high)

    return fold(e, FloatRanges(limits, variables))


def _loosened(low: float, high: float) -> Interval:
    return ends(low - LOOSE * max(1.0, abs(low)), high + LOOSE * max(1.0, abs(high)))


def _is_kept(e: ir.Expr) -> bool:
    """Returns whether a number is kept in a field, a variable or a parameter."""
    if isinstance(e, ir.At) and e.key.type.kind != "mix":
        return _is_kept(e.row)
    return isinstance(e, ir.FieldRead | ir.Local | ir.ParamRef)


def _claimed(subject: Form, known: Iterable[Fact]) -> Interval:
    """Returns the interval that the facts about a number leave to it."""
    low = -inf
    high = inf
    for fact in known:
        if fact.subject == subject:
            for bounds in (fact.claim.interval, fact.claim.reach):
                if bounds is not None:
                    low = max(low, bounds[0])
                    high = min(high, bounds[1])
    return low, high


@dataclass(frozen=True)
class Narrowing(Analysis[Interval]):
    """Folds numbers to the intervals that facts about them, their parts or sums of these leave.

    Of a number that isn't calculated from others, its type says all else that is known.
    forms, sums: of the parts of an expression, each computed once.
    """

    rules: ClassVar = {kind: BOUNDS[kind] for kind in (ir.Named, ir.Arithmetic)}
    known: Sequence[Fact]
    forms: Memo = field(default_factory=dict)
    sums: dict[int, Linear] = field(default_factory=dict)

    def leaf(self, e: ir.Expr) -> Interval:
        return e.type.low, e.type.high

    def calculated(self, e: ir.Arithmetic, parts: list[Interval]) -> Interval:
        if e.type.indexed_by:
            return e.type.low, e.type.high
        low, high = CALCULATIONS[e.fn].interval(*parts)
        return max(e.type.low, low), min(e.type.high, high)

    def refined(self, e: ir.Expr, result: Interval) -> Interval:
        """Returns an interval within what the known facts say of an expression."""
        claimed = _claimed(form(e, memo=self.forms), self.known)
        low = max(result[0], claimed[0])
        high = min(result[1], claimed[1])
        if not isinstance(e, ir.Arithmetic) or e.type.indexed_by or not CALCULATIONS[e.fn].factors:
            return low, high
        # what a fact says of a sum of whole numbers holds of it if they are not rounded
        usable = (fact for fact in self.known if e.type.kind == "real" or fact.is_exact)
        sums = (sum_ for fact in usable for sum_ in fact.not_negative)
        return narrowed_sum(linear(e, self.sums), (low, high), sums)


def narrowed(e: ir.Expr, known: Sequence[Fact]) -> Interval:
    """Returns the interval of a number.

    The facts about it, about its parts, or about sums of these are used.
    """
    return fold(e, Narrowing(known)) if known else (e.type.low, e.type.high)
