"""Monotonicity analysis: whether an expression rises or falls when another grows. This decides `monotone` statically.

Every operation is followed with the intervals of its parts; parameters of the game may have any value they can take.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Literal

from sjdsl.compiler import ir
from sjdsl.compiler.ir.evaluate_constant import holds
from sjdsl.compiler.ir.printer import expression as text

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
OPPOSITE: Mapping[Slope, Slope] = {"level": "level", "rising": "falling", "falling": "rising"}


def decide_monotone(check: ir.Check, game: ir.Game) -> bool:
    """Returns whether a `monotone` is proved; False: it is not known."""
    value, argument = check.values
    wanted: Slope = "rising" if check.words[0] == "rising" else "falling"
    params = {p.name: p.value for p in game.params}
    if _slope(value, text(argument), game, params) in ("level", wanted):
        return True
    atoms = _atoms(value, game) | _atoms(argument, game)
    if len(atoms) != 1:
        return False
    (atom,) = atoms
    own, other = _slope(value, atom, game, params), _slope(argument, atom, game, params)
    if own is None or other is None:
        return False
    return own == "level" or other == "level" or (own if other == "rising" else OPPOSITE[own]) == wanted


def _is_fixed(e: ir.Node, game: ir.Game) -> bool:
    """Returns whether an expression has one value throughout an episode."""
    if isinstance(e, ir.Count):
        d = e.domain
        return d.var.who == "cell" and d.restriction is None and d.where is None
    return not isinstance(e, READING) and all(_is_fixed(child, game) for child in ir.children(e))


def _atoms(e: ir.Node, game: ir.Game) -> set[str]:
    """Returns the texts of the largest parts that read the state."""
    if _is_fixed(e, game):
        return set()
    if ir.is_expression(e) and isinstance(e, READING):
        return {text(e)}
    return {atom for child in ir.children(e) for atom in _atoms(child, game)}


def _slope(e: ir.Expr, of: str, game: ir.Game, params: Mapping[str, Any]) -> Slope | None:
    """Returns the direction in which `e` changes when the expression with this text grows and all else stays; None: not known."""
    if text(e) == of or (isinstance(e, ir.Named) and text(e.value) == of):
        return "rising"
    if _is_fixed(e, game):
        return "level"
    match e:
        case ir.Named():
            return _slope(e.value, of, game, params)
        case ir.Ramp():
            return _ramp(e, of, game, params)
        case ir.Arithmetic():
            slopes = [slope for slope in (_slope(a, of, game, params) for a in e.args) if slope is not None]
            return _arithmetic(e, slopes) if len(slopes) == len(e.args) else None
        case _:
            return None


def _ramp(e: ir.Ramp, of: str, game: ir.Game, params: Mapping[str, Any]) -> Slope | None:
    """Returns the direction of a ramp. The compiler has proved that its ends never cross: their order in the file is their order always."""
    slope = _slope(e.value, of, game, params)
    if slope is None or not (_is_fixed(e.zero_at, game) and _is_fixed(e.one_at, game)):
        return None
    return slope if holds(ir.Compare(fn="<", left=e.zero_at, right=e.one_at), params) else OPPOSITE[slope]


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
            return _together([_scaled(left, b.type), _scaled(right, a.type)])
        case "/":
            (a, b), (left, right) = e.args, slopes
            if b.type.low < 0 < b.type.high:
                return None
            return _together([_scaled(left, b.type), _scaled(OPPOSITE[right], a.type)])
        case _:
            return None


def _scaled(slope: Slope | None, by: ir.Type) -> Slope | None:
    if slope == "level" or slope is None:
        return slope
    return slope if by.low >= 0 else OPPOSITE[slope] if by.high <= 0 else None


def _together(slopes: Sequence[Slope | None]) -> Slope | None:
    """Returns the direction of a sum whose parts have these directions."""
    moving = set(slopes) - {"level"}
    return "level" if not moving else next(iter(moving)) if len(moving) == 1 else None
