"""Monotonicity analysis: whether an expression rises or falls when another grows. This decides `monotone` statically.

Every operation is followed with the ranges of its parts; parameters of the game may have any value they can take.
"""

from collections.abc import Sequence

from sjdsl.compiler import ir
from sjdsl.compiler.ir.implications import Fact, compares, facts
from sjdsl.compiler.ir.operations import CALCULATIONS, OPPOSITE, Moving, Slope
from sjdsl.compiler.ir.printer import expression as text
from sjdsl.compiler.ir.range_arithmetic import INT32, Range
from sjdsl.compiler.ir.ranges import range_of

COMPUTED = (  # what has one value throughout an episode if its parts have; every other expression reads the state
    ir.Number | ir.Word | ir.Truth | ir.Nobody | ir.Nowhere | ir.ParamRef | ir.Arithmetic | ir.At | ir.SumRow | ir.ShiftRow | ir.Lowest | ir.Mix
    | ir.Named | ir.Narrowed | ir.Case | ir.Arm | ir.Compare | ir.InRange | ir.InWords | ir.Same | ir.Not | ir.Logic
)  # fmt: skip


def decide_monotone(check: ir.Check, game: ir.Game) -> bool:
    """Returns whether a `monotone` is proved; False: it is not known."""
    value, argument = check.values
    wanted: Slope = "rising" if check.words[0] == "rising" else "falling"
    known = tuple(
        fact for test in game.checks if test.sort == "require" for fact in facts(test.values[0])
    )
    if _slope(value, text(argument), known) in ("level", wanted):
        return True
    atoms = _atoms(value) | _atoms(argument)
    if len(atoms) != 1:
        return False
    (atom,) = atoms
    own, other = _slope(value, atom, known), _slope(argument, atom, known)
    if own is None or other is None:
        return False
    return (
        own == "level"
        or other == "level"
        or (own if other == "rising" else OPPOSITE[own]) == wanted
    )


def _is_fixed(e: ir.Node) -> bool:
    """Returns whether an expression has one value throughout an episode."""
    if isinstance(e, ir.Count):
        d = e.domain
        return d.var.sort.what == "cell" and d.restriction is None and d.where is None
    return isinstance(e, COMPUTED) and all(_is_fixed(child) for child in ir.children(e))


def _atoms(e: ir.Node) -> set[str]:
    """Returns the texts of the largest parts that read the state."""
    if _is_fixed(e):
        return set()
    if ir.is_expression(e) and not isinstance(e, COMPUTED):
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
        case ir.Arithmetic(args=args) if _stays(range_of(e)):
            parts = [
                Moving(slope, range_of(a))
                for a in args
                if (slope := _slope(a, of, known)) is not None
            ]
            if len(parts) < len(args):
                return None
            return CALCULATIONS[e.fn].slope(
                parts, lambda one, other: compares(args[one], "<", args[other], known)
            )
        case _:
            return None


def _stays(r: Range) -> bool:
    """Returns whether a result is what was computed: a whole number that does not wrap, a real that is one."""
    return (r.low, r.high) != INT32 if r.whole else r.sound
