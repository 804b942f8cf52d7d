"""The functions and operators of the language.

A row for each, with all that compiler, pages and editors know of it.

Whatever elaborates, folds, bounds, lowers, prints or describes an operation reads its row, and asks
for none by its name. The interpreter is the oracle and does not read this table: it has its own
meaning of each, and `tests/compiler/test_operations.py` compares the two.
"""

import math
import operator
from collections.abc import Callable, Iterable, Sequence
from dataclasses import KW_ONLY
from math import inf
from typing import Any, Literal, NamedTuple

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.range_arithmetic import (
    FLOAT32,
    SMALLEST,
    Range,
    differ_as_reals,
    disjoint,
    rounded,
    to_float32,
    whole_range,
)
from sjdsl.compiler.ir.types import SLACK, join_units, over_unit, times, times_unit

Interval = tuple[float, float]
Slope = Literal["level", "rising", "falling"]
OPPOSITE: dict[Slope, Slope] = {"level": "level", "rising": "falling", "falling": "rising"}


class Moving(NamedTuple):
    """An argument of a calculation while some number grows.

    The direction it goes in, and all that it can be.
    """

    slope: Slope
    range: Range


# The direction of a calculation from those of its arguments, None if it is not known. The second
# parameter of a rule says whether one argument is known to be less than another, both by their
# places.
SlopeRule = Callable[[Sequence[Moving], Callable[[int, int], bool]], Slope | None]


class Rounding(NamedTuple):
    """How float32 rounds a result: `terms` and `steady` as in `Range`.

    `once`: no more than once, if the arguments are exact.
    """

    terms: float
    steady: bool
    once: bool = True


class Domain(NamedTuple):
    """The numbers that a function takes, from `low` to `high`.

    above: `low` isn't one of them. named: what messages call them; instead: an argument in their
    place that is one of them.
    """

    low: float
    high: float
    above: bool
    named: str
    instead: str


class Reduction(Record):
    """What makes one number of all entries of a row, or of a number for each member of a domain."""

    fold: Callable[[Iterable[float]], float]  # its value for Python's numbers
    adds: bool  # it is a sum; otherwise it is one of the numbers
    array: Literal["sum", "min", "max"]  # the function of NumPy and JAX
    nothing: float  # the number that changes no result
    kept: str  # the name of the result in generated code


class Function(Record):
    """What authors write as a name with brackets behind it."""

    name: str
    # Each way to write it, and what that gives: for the cheat sheet and editors.
    uses: tuple[tuple[str, str], ...]
    builds: type[ir.Node]  # the class of its node in the IR
    least: int = 1  # number of arguments
    most: int = 1
    reduces: Reduction | None = None  # what it does with a row, or over a domain
    word: bool = False  # the grammar has a word and a rule for it
    yields: bool = False  # a `define` of the same name in a file is meant instead
    checks: tuple[str, ...] = ()  # the only checks that it stands in; empty: it stands everywhere
    last: bool = False  # `ir.Lowest.last`


def _joined(*units: ir.Unit) -> ir.Unit | None:
    """Returns the unit of numbers that are added or compared; None if they do not mix."""
    joined: ir.Unit | None = units[0]
    for unit in units[1:]:
        joined = None if joined is None else join_units(joined, unit)
    return joined


class Calculation(Function):
    """What makes one number of others. Its node is an `ir.Arithmetic` whose `fn` is its name."""

    _: KW_ONLY
    builds: type[ir.Node] = ir.Arithmetic
    sign: str = ""  # what authors write instead of the name: it is an operator

    # what it takes
    # Of an operation on two numbers: `cannot {verb} steps and rewards`; otherwise they cannot be
    # compared.
    verb: str = ""
    rows: bool = False  # also two rows of numbers, entry by entry
    whole_only: bool = False  # whole numbers only
    divisor: int | None = None  # the argument that must not be 0
    apart: tuple[int, int] | None = None  # two arguments that must differ
    bounded: bool = False  # the argument must be known to stay within the limits of numbers
    domain: Domain | None = None  # the argument must be known to be one of these
    finite: bool = False  # the result must be known to stay in float32

    # the type of its result
    # From the units of its arguments; None if they do not mix.
    unit: Callable[..., ir.Unit | None] = _joined
    # Also where the result leaves the limits of that unit; else it becomes a bare number there.
    keeps_unit: bool = False
    # joined: whole if all arguments are; whole: the result of `array` becomes int32.
    kind: Literal["joined", "whole", "real"] = "joined"
    unchanged: bool = False  # a whole argument is the result itself
    share: bool = False  # `count(some of them) / count(them)` is a fraction

    # its value
    fold: Callable[..., float]  # for Python's numbers
    # All that it can be, from the interval of each argument; as exact numbers.
    interval: Callable[..., Interval]
    factors: tuple[int, ...] = ()  # it is the sum of its arguments, each times one of these
    slope: SlopeRule
    # Of two reals in float32; None: the result is exact.
    rounding: Callable[[Range, Range], Rounding] | None = None
    # All that it can be in float32; None: as `interval` and `rounding` say.
    range: Callable[[Sequence[Range]], Range] | None = None

    # its code
    # An operator of Python, or a function of arrays; one of two arrays is applied to one argument
    # after another.
    array: str
    exact: str = ""  # the function of arrays in its place where the result decides something


class PayoffClass(Function):
    """A class of 2 x 2 games.

    Source: Macy and Flache 2002, the orders of R, S, T, P: prisoner's dilemma T > R > P > S and 2R
    > T + S; stag hunt R > T >= P > S; chicken T > R > S > P. Their 2R > T + S is not asked of a
    chicken game: taking turns may pay more than cooperating, as in the one of Melting Pot (3, 2 /
    5, 0).
    """

    _: KW_ONLY
    # For the payoffs R, S, T and P of the row player.
    holds: Callable[[float, float, float, float], bool]


class Comparison(Record):
    """A sign that compares two numbers."""

    holds: Callable[[Any, Any], Any]  # for two numbers, or two arrays of them
    mirror: ir.Comparison  # the sign that says the same of the two exchanged
    opposite: ir.Comparison  # the sign that holds where this one does not
    named: str  # between their names, in generated code


# ---- intervals


def _product(a: Interval, b: Interval) -> Interval:
    """Returns the interval of a product."""
    corners = [times(x, y) for x in a for y in b]
    return min(corners), max(corners)


def _quotient(a: Interval, b: Interval) -> Interval:
    """Returns the interval of a quotient."""
    # The ends are the wrong way round where conditions contradict each other.
    if min(b) <= 0 <= max(b):
        return -inf, inf
    corners = [x / y if abs(y) != inf else 0.0 for x in a for y in b]
    return min(corners), max(corners)


def _whole_quotient(a: Interval, b: Interval) -> Interval:
    """Returns the interval of a quotient of whole numbers that is rounded down."""
    low, high = b
    divisors = [y for y in (low, -1, 1, high) if y and low <= y <= high]
    if not divisors:  # where it is 0, nothing is divided
        divisors = [-1, 1]
    corners = [_rounded_down(x, y) for x in a for y in divisors]
    return min(corners), max(corners)


def _rounded_down(x: float, y: float) -> float:
    """Returns the quotient of two ends of intervals of whole numbers, rounded down."""
    if abs(x) == inf:
        return x if y > 0 else -x
    if abs(y) == inf:
        return -1 if x and (x < 0) != (y < 0) else 0
    return x // y


def _nearest_whole(a: Interval) -> Interval:
    """Returns the interval of the whole numbers nearest to reals.

    Float32 arithmetic may pass the ends of their interval by a little.
    """
    low, high = (
        end if abs(end) == inf else round(end + slack * max(1.0, abs(end)))
        for end, slack in zip(a, (-SLACK, SLACK), strict=True)
    )
    return low, high


def _power(a: Interval, exponent: Interval) -> Interval:
    """Returns the interval of a power with a fixed exponent, a whole number that isn't negative."""
    number = int(exponent[0])
    low, high = (_multiplied(end, number) for end in a)
    if number % 2:
        return low, high
    least = 0 if number and a[0] <= 0 <= a[1] else min(low, high)
    return least, max(low, high)


def _multiplied(base: float, number: int) -> float:
    """Returns a power of a number; infinite beyond float32."""
    try:
        power: float = base**number
    except OverflowError:
        power = inf
    if abs(power) <= FLOAT32:
        return power
    return -inf if base < 0 and number % 2 else inf


# ---- slopes


def _together(slopes: Sequence[Slope | None]) -> Slope | None:
    """Returns the direction of what rises with each of its parts, from theirs."""
    moving = set(slopes) - {"level"}
    if not moving:
        return "level"
    return moving.pop() if len(moving) == 1 else None


def _scaled(slope: Slope, by: Range) -> Slope | None:
    """Returns the direction of a product with a number of this range."""
    if slope == "level" or by.low >= 0:
        return slope
    return OPPOSITE[slope] if by.high <= 0 else None


def _quotient_slope(a: Moving, b: Moving) -> Slope | None:
    """Returns the direction of a quotient."""
    if b.range.low <= 0 <= b.range.high:
        return None
    return _together([_scaled(a.slope, b.range), _scaled(OPPOSITE[b.slope], a.range)])


def _ramp_slope(parts: Sequence[Moving], below: Callable[[int, int], bool]) -> Slope | None:
    """Returns the direction of a ramp between two ends that stay where they are.

    None if they don't, or if it isn't known which of them is greater.
    """
    value, zero_at, one_at = parts
    if not zero_at.slope == one_at.slope == "level":
        return None
    zero = to_float32(zero_at.range)
    one = to_float32(one_at.range)
    if zero.high < one.low or below(1, 2):
        return value.slope
    return OPPOSITE[value.slope] if one.high < zero.low or below(2, 1) else None


def _power_slope(base: Moving, exponent: Moving) -> Slope | None:
    """Returns the direction of a power with a fixed exponent."""
    number = int(exponent.range.low)
    if number == 0:
        return "level"
    return base.slope if number % 2 else _scaled(base.slope, base.range)


# ---- ranges in float32


def _quotient_rounding(a: Range, b: Range) -> Rounding:
    """Returns how float32 rounds a quotient."""
    least = min(abs(b.low), abs(b.high))
    terms = times(a.terms / least, max(1.0, b.terms / least))
    return Rounding(terms, True, once=False)  # XLA may multiply by 1 / b


def _ramp_range(parts: Sequence[Range]) -> Range:
    """Returns the range of a ramp; it may be NaN if its ends may be equal, or far apart."""
    value, zero, one = map(to_float32, parts)
    _, zero_at, one_at = parts
    # The ends differ, as a guard or a `require` says.
    are_exact = zero_at.rounded_once and one_at.rounded_once
    differ = disjoint(zero_at, one_at) or (are_exact and differ_as_reals(zero_at, one_at))
    are_sound = value.sound and zero.sound and one.sound
    sound = are_sound and differ and zero.largest + one.largest <= FLOAT32
    return Range(0.0, 1.0, terms=1.0, rounded_once=False, sound=sound)


def _range_by(interval: Callable[[Interval], Interval]) -> Callable[[Sequence[Range]], Range]:
    """Returns the rule for the range of a function that is computed with several roundings."""

    def range_(parts: Sequence[Range]) -> Range:
        value = to_float32(parts[0])
        low, high = interval((value.low, value.high))
        largest = max(abs(low), abs(high))
        return rounded(
            Range(low, high, terms=largest, sound=value.sound, literal=value.literal), ROUNDINGS
        )

    return range_


def _power_range(parts: Sequence[Range]) -> Range:
    """Returns the range of a power, which is rounded once for each factor after the first."""
    base, exponent = parts
    low, high = _power((base.low, base.high), (exponent.low, exponent.high))
    if base.whole:
        return whole_range(low, high, base)
    terms = _multiplied(base.terms, int(exponent.low))
    finite = max(abs(low), abs(high)) <= FLOAT32
    power = Range(
        low,
        high,
        terms=terms,
        steady=base.steady,
        sound=base.sound and finite,
        literal=base.literal,
    )
    return rounded(power, max(1.0, exponent.low))


def _operator(sign: str, gives: str, array: str = "", **columns: Any) -> Calculation:
    """Returns the row of an operator between two numbers. array: empty if it is the same there."""
    uses = ((f"a {sign} b", gives),)
    return Calculation(
        name=sign, uses=uses, least=2, most=2, sign=sign, array=array or sign, **columns
    )


def _elementary(
    name: str,
    gives: str,
    domain: Domain,
    fold: Callable[[float], float],
    array: str,
    exact: str = "",
) -> Calculation:
    """Returns the row of a function that rises with its argument. exact: empty if it is `array`."""

    def interval(a: Interval) -> Interval:
        low = fold(a[0])
        is_tiny = 0 < low < SMALLEST
        return 0.0 if is_tiny else low, fold(a[1])

    return Calculation(
        name=name,
        uses=((f"{name}(x)", gives),),
        yields=True,
        domain=domain,
        unit=lambda _: "number",
        kind="real",
        fold=fold,
        interval=interval,
        slope=lambda parts, _: parts[0].slope,
        range=_range_by(interval),
        array=array,
        exact=exact or array,
    )


# ---- the table

GREATEST_EXPONENT = 88.0  # of e; e^89 is no float32
ROUNDINGS = 4  # a root or a logarithm is off by less than so many units in the last place
NOT_NEGATIVE = Domain(0.0, inf, False, "numbers from 0 up", "max({}, 0)")
POSITIVE = Domain(SMALLEST, inf, True, "numbers above 0", "max({}, 0.001)")
SMALL = Domain(-inf, GREATEST_EXPONENT, False, "numbers up to 88", "min({}, 88)")

OPERATIONS: tuple[Function, ...] = (
    Function("count", (("count(D)", "how many members a domain has"),), ir.Count, word=True),
    Function(
        "sum",
        (
            ("sum(e over D)", "the sum of e over a domain"),
            ("sum(row)", "the sum of a row's entries"),
        ),
        ir.Sum,
        word=True,
        reduces=Reduction(sum, True, "sum", 0, "total"),
    ),
    Calculation(
        name="min",
        uses=(
            ("min(a, b, …)", "the least of two to eight numbers"),
            ("min(row)", "the least entry of a row"),
            ("min(e over D otherwise v)", "the least e over a domain, v where it has no member"),
        ),
        least=2,
        most=8,
        reduces=Reduction(min, False, "min", inf, "least"),
        keeps_unit=True,
        fold=min,
        interval=lambda *of: (min(low for low, _ in of), min(high for _, high in of)),
        slope=lambda parts, _: _together([p.slope for p in parts]),
        array="jnp.minimum",
    ),
    Calculation(
        name="max",
        uses=(
            ("max(a, b, …)", "the greatest of two to eight numbers"),
            ("max(row)", "the greatest entry of a row"),
            ("max(e over D otherwise v)", "the greatest e over a domain, v where it has no member"),
        ),
        least=2,
        most=8,
        reduces=Reduction(max, False, "max", -inf, "greatest"),
        keeps_unit=True,
        fold=max,
        interval=lambda *of: (max(low for low, _ in of), max(high for _, high in of)),
        slope=lambda parts, _: _together([p.slope for p in parts]),
        array="jnp.maximum",
    ),
    Calculation(
        name="ramp",
        uses=(
            (
                "ramp(x, zero_at, one_at)",
                "0 at zero_at, 1 at one_at, straight between, 0 and 1 beyond",
            ),
        ),
        least=3,
        most=3,
        apart=(1, 2),
        unit=lambda *units: None if _joined(*units) is None else "fraction",
        kind="real",
        fold=lambda x, zero, one: min(max((x - zero) / (one - zero), 0.0), 1.0),
        interval=lambda *_: (0.0, 1.0),
        slope=_ramp_slope,
        range=_ramp_range,
        array="ramp",
        exact="exact_ramp",
    ),
    Function(
        "distance",
        (
            (
                "distance(a, b)",
                "steps along rows and columns, whatever stands between; where the map wraps, the "
                "shorter way round",
            ),
        ),
        ir.Distance,
        least=2,
        most=2,
        yields=True,
    ),
    Function(
        "steps_ahead",
        (
            (
                "steps_ahead(a, b)",
                "how many steps ahead of a b is, whatever stands between; negative behind it",
            ),
        ),
        ir.Bearing,
        least=2,
        most=2,
        yields=True,
    ),
    Function(
        "steps_right",
        (("steps_right(a, b)", "how many steps to the right of a b is; negative to its left"),),
        ir.Bearing,
        least=2,
        most=2,
        yields=True,
    ),
    Function(
        "shift",
        (
            (
                "shift(row, n, x)",
                "the row with each entry moved n places on, x in the n places that this empties",
            ),
        ),
        ir.ShiftRow,
        least=3,
        most=3,
        yields=True,
    ),
    Calculation(
        name="quotient",
        uses=(("quotient(a, b)", "a / b of whole numbers, rounded down"),),
        least=2,
        most=2,
        yields=True,
        verb="divide",
        whole_only=True,
        divisor=1,
        unit=over_unit,
        fold=operator.floordiv,
        interval=_whole_quotient,
        slope=lambda *_: None,
        array="//",
    ),
    Calculation(
        name="round",
        uses=(("round(x)", "the nearest whole number; of two, the even one"),),
        yields=True,
        bounded=True,
        unit=lambda a: "reward" if a == "reward" else "number",
        kind="whole",
        unchanged=True,
        fold=round,
        interval=_nearest_whole,
        slope=lambda parts, _: parts[0].slope,
        array="jnp.rint",
    ),
    Calculation(
        name="abs",
        uses=(("abs(x)", "x without its sign"),),
        yields=True,
        keeps_unit=True,
        fold=abs,
        interval=lambda a: (max(a[0], -a[1], 0), max(-a[0], a[1])),
        slope=lambda parts, _: _scaled(*parts[0]),
        array="jnp.abs",
    ),
    _elementary(
        "sqrt",
        "the square root of a number that isn't negative",
        NOT_NEGATIVE,
        lambda x: math.sqrt(max(x, 0.0)),
        "root",
        exact="exact_root",
    ),
    _elementary(
        "exp",
        "e to the power of x, which is at most 88",
        SMALL,
        lambda x: math.exp(min(x, GREATEST_EXPONENT)),
        "exponential",
    ),
    _elementary(
        "log",
        "the natural logarithm of a number above 0",
        POSITIVE,
        lambda x: math.log(max(x, SMALLEST)),
        "logarithm",
    ),
    Function(
        "lowest", (("lowest(row)", "the first word of the row whose entry is above 0"),), ir.Lowest
    ),
    Function(
        "highest",
        (("highest(row)", "the last word of the row whose entry is above 0"),),
        ir.Lowest,
        last=True,
    ),
    Function(
        "mix",
        (
            (
                "mix(row)",
                "as a table's index: payoff[mix(a.bag)] is the mean of the payoffs, weighted with "
                "the row's entries",
            ),
        ),
        ir.Mix,
    ),
    PayoffClass(
        name="prisoners_dilemma",
        uses=(("prisoners_dilemma(table)", "in `require`: T > R > P > S and 2R > T + S"),),
        builds=ir.MatrixClass,
        checks=("require",),
        holds=lambda r, s, t, p: t > r > p > s and 2 * r > t + s,
    ),
    PayoffClass(
        name="stag_hunt",
        uses=(("stag_hunt(table)", "in `require`: R > T >= P > S"),),
        builds=ir.MatrixClass,
        checks=("require",),
        holds=lambda r, s, t, p: r > t >= p > s,
    ),
    PayoffClass(
        name="chicken",
        uses=(("chicken(table)", "in `require`: T > R > S > P"),),
        builds=ir.MatrixClass,
        checks=("require",),
        holds=lambda r, s, t, p: t > r > s > p,
    ),
    Function(
        "before",
        (("before(e)", "in `always` and `once`: e when the step began"),),
        ir.Before,
        yields=True,
        checks=("always", "once"),
    ),
    # ---- operators
    Calculation(
        name="neg",
        uses=(("-a", "a with the other sign"),),
        sign="-",
        keeps_unit=True,
        fold=operator.neg,
        interval=lambda a: (-a[1], -a[0]),
        factors=(-1,),
        slope=lambda parts, _: OPPOSITE[parts[0].slope],
        array="-",
    ),
    _operator(
        "+",
        "of numbers, or of rows entry by entry",
        verb="add",
        rows=True,
        fold=operator.add,
        interval=lambda a, b: (a[0] + b[0], a[1] + b[1]),
        factors=(1, 1),
        slope=lambda parts, _: _together([p.slope for p in parts]),
        rounding=lambda a, b: Rounding(
            a.terms + b.terms, (a.low >= 0 and b.low >= 0) or (a.high <= 0 and b.high <= 0)
        ),
    ),
    _operator(
        "-",
        "of numbers, or of rows entry by entry",
        verb="subtract",
        rows=True,
        fold=operator.sub,
        interval=lambda a, b: (a[0] - b[1], a[1] - b[0]),
        factors=(1, -1),
        slope=lambda parts, _: _together([parts[0].slope, OPPOSITE[parts[1].slope]]),
        rounding=lambda a, b: Rounding(
            a.terms + b.terms, (a.low >= 0 and b.high <= 0) or (a.high <= 0 and b.low >= 0)
        ),
    ),
    _operator(
        "*",
        "of numbers",
        verb="multiply",
        unit=times_unit,
        fold=operator.mul,
        interval=_product,
        slope=lambda parts, _: _together(
            [_scaled(parts[0].slope, parts[1].range), _scaled(parts[1].slope, parts[0].range)]
        ),
        rounding=lambda a, b: Rounding(times(a.terms, b.terms), True),
    ),
    _operator(
        "/",
        "a real number",
        verb="divide",
        divisor=1,
        unit=over_unit,
        kind="real",
        share=True,
        fold=operator.truediv,
        interval=_quotient,
        slope=lambda parts, _: _quotient_slope(*parts),
        rounding=_quotient_rounding,
        exact="divided",
    ),
    _operator(
        "%",
        "the remainder of whole numbers, with the sign of b",
        verb="take the remainder of",
        whole_only=True,
        divisor=1,
        fold=operator.mod,
        interval=lambda _, b: (0, b[1] - 1) if b[0] > 0 else (min(b[0] + 1, 0), max(b[1] - 1, 0)),
        slope=lambda *_: None,
    ),
    _operator(
        "^",
        "a to the power of b; a is above 0 unless b is a whole number known when the game is compiled",
        verb="take a power of",
        unit=lambda a, b: times_unit(a, a) if b in ("number", "count") else None,
        finite=True,
        fold=lambda a, b: _multiplied(a, int(b)),
        interval=_power,
        slope=lambda parts, _: _power_slope(*parts),
        range=_power_range,
        array="powered",
        exact="powered",
    ),
)
COMPARISONS: dict[str, Comparison] = {
    "<": Comparison(operator.lt, ">", ">=", "below"),
    "<=": Comparison(operator.le, ">=", ">", "at_most"),
    ">": Comparison(operator.gt, "<", "<=", "above"),
    ">=": Comparison(operator.ge, "<=", "<", "at_least"),
    "==": Comparison(operator.eq, "==", "!=", "is"),
    "!=": Comparison(operator.ne, "!=", "==", "is_not"),
}
FUNCTIONS = {row.name: row for row in OPERATIONS if not (isinstance(row, Calculation) and row.sign)}
CALCULATIONS = {row.name: row for row in OPERATIONS if isinstance(row, Calculation)}
REDUCTIONS = {row.name: row.reduces for row in OPERATIONS if row.reduces is not None}
PAYOFF_CLASSES = {row.name: row for row in OPERATIONS if isinstance(row, PayoffClass)}
INFIX = {row.sign: row for row in CALCULATIONS.values() if row.sign and row.most == 2}
PREFIX = {row.sign: row for row in CALCULATIONS.values() if row.sign and row.most == 1}
