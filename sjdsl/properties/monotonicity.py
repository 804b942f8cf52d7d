"""Monotonicity analysis: whether an expression rises or falls when another grows. This decides `monotone` statically.

Every operation is followed with the ranges of its parts; parameters of the game may have any value they can take.
"""

from collections.abc import Mapping, Sequence
from typing import Literal

from sjdsl.compiler import ir
from sjdsl.compiler.ir.implications import Fact, compares, facts
from sjdsl.compiler.ir.printer import expression as text
from sjdsl.compiler.ir.ranges import INT32, Range, range_of, real

Slope = Literal["level", "rising", "falling"]
READING = (
    ir.FieldRead
    | ir.Count
    | ir.Sum
    | ir.Extreme
    | ir.Attribute
    | ir.Distance
    | ir.Step
    | ir.EventTotal
    | ir.Unoccupied
    | ir.StandsOn
    | ir.Local
    | ir.Member
    | ir.InSet
    | ir.Before
)
COMPUTED = (  # what has one value throughout an episode if its parts have
    ir.Number
    | ir.Word
    | ir.Truth
    | ir.ParamRef
    | ir.Arithmetic
    | ir.At
    | ir.SumRow
    | ir.ShiftRow
    | ir.Lowest
    | ir.Mix
    | ir.Ramp
    | ir.Named
    | ir.Narrowed
    | ir.Case
    | ir.Arm
    | ir.Compare
    | ir.InRange
    | ir.InWords
    | ir.Same
    | ir.Not
    | ir.Logic
)
OPPOSITE: Mapping[Slope, Slope] = {"level": "level", "rising": "falling", "falling": "rising"}


def decide_monotone(check: ir.Check, game: ir.Game) -> bool:
    """Returns whether a `monotone` is proved; False: it is not known."""
    value, argument = check.values
    wanted: Slope = "rising" if check.words[0] == "rising" else "falling"
    known = tuple(fact for test in game.checks if test.sort == "require" for fact in facts(test.values[0]))
    if _slope(value, text(argument), known) in ("level", wanted):
        return True
    atoms = _atoms(value) | _atoms(argument)
    if len(atoms) != 1:
        return False
    (atom,) = atoms
    own, other = _slope(value, atom, known), _slope(argument, atom, known)
    if own is None or other is None:
        return False
    return own == "level" or other == "level" or (own if other == "rising" else OPPOSITE[own]) == wanted


def _is_fixed(e: ir.Node) -> bool:
    """Returns whether an expression has one value throughout an episode."""
    if isinstance(e, ir.Count):
        d = e.domain
        return d.var.who == "cell" and d.restriction is None and d.where is None
    return isinstance(e, COMPUTED) and all(_is_fixed(child) for child in ir.children(e))


def _atoms(e: ir.Node) -> set[str]:
    """Returns the texts of the largest parts that read the state."""
    if _is_fixed(e):
        return set()
    if ir.is_expression(e) and isinstance(e, READING):
        return {text(e)}
    return {atom for child in ir.children(e) for atom in _atoms(child)}


def _slope(e: ir.Expr, of: str, known: Sequence[Fact]) -> Slope | None:
    """Returns the direction in which `e` changes when the expression with this text grows and all else stays; None: not known.

    Every operation rounds, and a number that is larger is not smaller when it is rounded.
    """
    if text(e) == of or (isinstance(e, ir.Named) and text(e.value) == of):
        return "rising"
    if _is_fixed(e):
        return "level"
    match e:
        case ir.Named():
            return _slope(e.value, of, known)
        case ir.Ramp():
            return _ramp(e, of, known)
        case ir.Arithmetic() if _stays(range_of(e)):
            slopes = [slope for slope in (_slope(a, of, known) for a in e.args) if slope is not None]
            return _arithmetic(e, slopes) if len(slopes) == len(e.args) else None
        case _:
            return None


def _stays(r: Range) -> bool:
    """Returns whether a result is what was computed: a whole number that does not wrap, a real that is one."""
    return (r.low, r.high) != INT32 if r.whole else r.sound


def _ramp(e: ir.Ramp, of: str, known: Sequence[Fact]) -> Slope | None:
    """Returns the direction of a ramp, if it is known which of its ends is greater: by their ranges or a `require`."""
    slope = _slope(e.value, of, known)
    if slope is None or not (_is_fixed(e.zero_at) and _is_fixed(e.one_at) and range_of(e).sound):
        return None
    zero, one = (real(range_of(end)) for end in (e.zero_at, e.one_at))
    if zero.high < one.low or compares(e.zero_at, "<", e.one_at, known):
        return slope
    return OPPOSITE[slope] if one.high < zero.low or compares(e.one_at, "<", e.zero_at, known) else None


def _arithmetic(e: ir.Arithmetic, slopes: list[Slope]) -> Slope | None:
    match e.fn:
        case "neg":
            return OPPOSITE[slopes[0]]
        case "round":
            return slopes[0]
        case "+" | "min" | "max":
            return _together(slopes)
        case "-":
            return _together([slopes[0], OPPOSITE[slopes[1]]])
        case "*":
            (a, b), (left, right) = e.args, slopes
            return _together([_scaled(left, range_of(b)), _scaled(right, range_of(a))])
        case "/":
            (a, b), (left, right) = e.args, slopes
            divisor = range_of(b)
            if divisor.low <= 0 <= divisor.high:
                return None
            return _together([_scaled(left, divisor), _scaled(OPPOSITE[right], range_of(a))])
        case _:
            return None


def _scaled(slope: Slope, by: Range) -> Slope | None:
    if slope == "level":
        return slope
    return slope if by.low >= 0 else OPPOSITE[slope] if by.high <= 0 else None


def _together(slopes: Sequence[Slope | None]) -> Slope | None:
    """Returns the direction of a sum whose parts have these directions."""
    moving = set(slopes) - {"level"}
    return "level" if not moving else next(iter(moving)) if len(moving) == 1 else None
