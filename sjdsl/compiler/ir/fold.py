"""The fold over expressions: what each class of node makes of its parts, in one row of a table.

An analysis says what expressions are folded to: values (`values.py`), ranges in float32
(`ranges.py`), intervals of whole numbers (`checks/value_ranges.py`), slopes. It also is the
environment: it knows what parameters and fields are, and what the guards around imply. A new
expression gets a row in `VALUES`, and one in `BOUNDS` if more is known of it than its type says;
then every analysis knows it.
"""

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from operator import mul
from typing import Any, ClassVar, Generic, Self, TypeVar

from sjdsl.compiler import ir
from sjdsl.compiler.ir.operations import PAYOFF_CLASSES, REDUCTIONS

V = TypeVar("V")
Rule = Callable[[Any, Any], Any]  # of a node and an analysis


class UnknownValue(Exception):
    """A value depends on something that the environment does not know."""


class Analysis(Generic[V]):
    """What expressions are folded to, and what is known, at one place of the rules.

    rules: what nodes make of their parts, by class; every other node is a leaf.
    """

    rules: ClassVar[Mapping[type[ir.Node], Rule]]

    def leaf(self, _e: ir.Expr) -> V:
        """Returns what is known of an expression by itself. Raises UnknownValue."""
        raise UnknownValue

    def refined(self, _e: ir.Expr, result: V) -> V:
        """Returns the result for an expression, once all else that is known of it is used."""
        return result

    def inside(self, _domain: ir.Domain) -> Self:
        """Returns the place where the variables of a domain are members of it."""
        return self

    def in_arm(self, _e: ir.Case, _arm: ir.Arm) -> Self:
        """Returns the place where an arm of a `case` applies."""
        return self

    def before(self) -> Self:
        """Returns the place where expressions are those of the state before the step."""
        return self


def fold(e: ir.Expr, analysis: Analysis[V]) -> V:
    """Returns what an analysis says of an expression: a value, a range. Raises UnknownValue."""
    rule = analysis.rules.get(type(e))
    result = analysis.leaf(e) if rule is None else rule(e, analysis)
    return analysis.refined(e, result)


def is_computed(e: ir.Node) -> bool:
    """Returns whether the value of an expression depends on its parts alone."""
    return type(e) in VALUES


def _of_value(e: Any, analysis: Analysis[V]) -> V:
    """Returns what an expression is that only gives another a name or a narrower type."""
    return fold(e.value, analysis)


# ---- values: each function says what the expressions of a class are, by the table VALUES


def _written(e: Any, _: Any) -> Any:
    return e.value


def _calculated_value(e: ir.Arithmetic, analysis: Any) -> Any:
    """Returns the value of an operator or function, entry by entry of rows."""
    values = [fold(part, analysis) for part in e.args]
    try:
        return _entry_by_entry(partial(analysis.calculated, e), *values)
    except ZeroDivisionError as error:  # only where a guard doesn't hold, which isn't read here
        raise UnknownValue from error


def _entry_by_entry(calculated: Callable[..., Any], *values: Any) -> Any:
    """Returns what is calculated from numbers, or from rows and tables with the same keys."""
    if isinstance(values[0], tuple):
        entries = zip(*values, strict=True)
        return tuple(_entry_by_entry(calculated, *entry) for entry in entries)
    return calculated(*values)


def _entry_value(e: ir.At, analysis: Any) -> Any:
    """Returns the value of `row[key]`, or of the mean of entries that a mix weighs."""
    row = fold(e.row, analysis)
    key = fold(e.key, analysis)
    if e.key.type.kind == "mix":
        return analysis.rounded(sum(map(mul, key, row)))
    index_set = e.row.type.indexed_by[0]
    # A key of none of the entries: a guard excludes it.
    if key is None or (isinstance(key, str) and key not in index_set.names):
        raise UnknownValue
    place = index_set.place_of(key)
    if not 0 <= place < len(index_set):
        raise UnknownValue
    return row[place]


def _reduced_value(e: ir.SumRow, analysis: Any) -> Any:
    reduction = REDUCTIONS[e.fn]
    value = reduction.fold(fold(e.row, analysis))
    return analysis.rounded(value) if reduction.adds and e.type.kind == "real" else value


def _shifted_value(e: ir.ShiftRow, analysis: Any) -> Any:
    row = fold(e.row, analysis)
    filler = fold(e.filler, analysis)
    places = [place - e.by for place in range(len(row))]
    return tuple(row[place] if 0 <= place < len(row) else filler for place in places)


def _lowest_value(e: ir.Lowest, analysis: Any) -> Any:
    """Returns the first, or the last, entry above 0; of all entries if none is."""
    index_set = e.row.type.indexed_by[0]
    above = [place for place, entry in enumerate(fold(e.row, analysis)) if entry > 0]
    places = above or range(len(index_set))
    place = places[-1 if e.last else 0]
    return index_set.names[place] if e.type.kind == "word" else index_set.first + place


def _shares(e: ir.Mix, analysis: Any) -> Any:
    """Returns the entries of a row divided by their sum."""
    row = fold(e.row, analysis)
    total = sum(row)
    if not total:  # a guard excludes it
        raise UnknownValue
    return tuple(analysis.rounded(entry / total) for entry in row)


def _value_of_arm(e: ir.Case, analysis: Any) -> Any:
    subject = fold(e.subject, analysis)
    arm = next(arm for arm in e.arms if _applies(arm, subject))
    return fold(arm.value, analysis)


def _applies(arm: ir.Arm, subject: bool | int | str) -> bool:
    """Returns whether an arm of a `case` is for this word, truth or number."""
    if isinstance(subject, bool):
        subject = "yes" if subject else "no"
    if isinstance(subject, str):
        return subject in arm.words
    return (arm.low is None or arm.low <= subject) and (arm.high is None or subject <= arm.high)


def _is_one_of_words(e: ir.InWords, analysis: Any) -> bool:
    return set(e.value.type.words) <= set(e.words) or fold(e.value, analysis) in e.words


def _is_in_range(e: ir.InRange, analysis: Any) -> bool:
    is_high_enough = partial(analysis.compares, e, "<=", e.low, e.value)
    is_low_enough = partial(analysis.compares, e, "<=", e.value, e.high)
    return _joined("and", (is_high_enough, is_low_enough))


def _joined(fn: str, conditions: Iterable[Callable[[], bool]]) -> bool:
    """Returns whether all (`and`) or some (`or`) of the conditions hold. Raises UnknownValue.

    A condition that isn't known only matters if no other decides.
    """
    deciding = fn == "or"
    unknown = False
    for condition in conditions:
        try:
            if condition() == deciding:
                return deciding
        except UnknownValue:
            unknown = True
    if unknown:
        raise UnknownValue
    return not deciding


def _is_of_class(e: ir.MatrixClass, analysis: Any) -> bool:
    (r, s), (t, p) = fold(e.table, analysis)
    return PAYOFF_CLASSES[e.name].holds(r, s, t, p)


# Values. The analysis calculates (`calculated`, `rounded`) and compares (`compares`) numbers.
VALUES: dict[type[ir.Node], Rule] = {
    ir.Number: _written,
    ir.Word: _written,
    ir.Truth: _written,
    ir.Nobody: lambda *_: None,
    ir.Nowhere: lambda *_: None,
    ir.Named: _of_value,
    ir.Narrowed: _of_value,
    ir.Arithmetic: _calculated_value,
    ir.At: _entry_value,
    ir.SumRow: _reduced_value,
    ir.ShiftRow: _shifted_value,
    ir.Lowest: _lowest_value,
    ir.Mix: _shares,
    ir.Case: _value_of_arm,
    ir.Compare: lambda e, analysis: analysis.compares(e, e.fn, e.left, e.right),
    ir.InRange: _is_in_range,
    ir.InWords: _is_one_of_words,
    ir.Same: lambda e, analysis: fold(e.left, analysis) == fold(e.right, analysis),
    ir.IsEmpty: lambda e, analysis: not fold(e.container, analysis),
    ir.Not: lambda e, analysis: not fold(e.value, analysis),
    ir.Logic: lambda e, analysis: _joined(e.fn, [partial(fold, part, analysis) for part in e.args]),
    ir.MatrixClass: _is_of_class,
}


# ---- bounds: the same, by the table BOUNDS


def _reduced_bounds(e: ir.SumRow, analysis: Any) -> Any:
    row = fold(e.row, analysis)
    number = len(e.row.type.indexed_by[0])
    return analysis.total(row, number, number) if REDUCTIONS[e.fn].adds else row


def _extreme_bounds(e: ir.Extreme, analysis: Any) -> Any:
    parts = [fold(e.value, analysis.inside(e.domain))]
    if e.otherwise is not None:
        parts.append(fold(e.otherwise, analysis))
    return analysis.either(e, parts)


def _case_bounds(e: ir.Case, analysis: Any) -> Any:
    fold(e.subject, analysis)
    return analysis.either(e, [fold(arm.value, analysis.in_arm(e, arm)) for arm in e.arms])


# All that a number, or an entry of a row of numbers, can be. The analysis says what bounds a
# calculation (`calculated`), one of several numbers (`either`), the entry of a row (`entry`), and a
# sum (`total`, of at most `most` numbers).
BOUNDS: dict[type[ir.Node], Rule] = {
    ir.Named: _of_value,
    ir.Narrowed: _of_value,
    ir.Before: lambda e, analysis: fold(e.value, analysis.before()),
    ir.Arithmetic: lambda e, analysis: analysis.calculated(
        e, [fold(part, analysis) for part in e.args]
    ),
    ir.At: lambda e, analysis: analysis.entry(e, fold(e.row, analysis)),
    ir.SumRow: _reduced_bounds,
    ir.ShiftRow: lambda e, analysis: analysis.either(
        e, [fold(e.row, analysis), fold(e.filler, analysis)]
    ),
    ir.Sum: lambda e, analysis: analysis.total(
        fold(e.value, analysis.inside(e.domain)), 0, analysis.most(e)
    ),
    ir.Extreme: _extreme_bounds,
    ir.Case: _case_bounds,
}
