"""Decides `monotone`: whether an expression rises or falls when another grows.

Every operation is followed with the ranges of its parts; parameters of the game may have any value
that they can take.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from sjdsl.compiler import ir
from sjdsl.compiler.ir.fold import BOUNDS, Analysis, fold, is_computed
from sjdsl.compiler.ir.implications import Fact, compares, facts
from sjdsl.compiler.ir.operations import CALCULATIONS, OPPOSITE, Moving, Slope
from sjdsl.compiler.ir.printer import expression_text as text
from sjdsl.compiler.ir.queries import is_number_of_cells
from sjdsl.compiler.ir.range_arithmetic import INT32, Range
from sjdsl.compiler.ir.ranges import range_of


def decide_monotone(check: ir.Check, game: ir.Game) -> bool:
    """Returns whether a `monotone` is proved; False if it isn't known."""
    value, argument = check.values
    wanted: Slope = "rising" if check.words[0] == "rising" else "falling"
    known: list[Fact] = []
    for test in game.checks:
        if test.kind == "require":
            known += facts(test.values[0])
    if fold(value, Slopes(text(argument), known)) in ("level", wanted):
        return True
    atoms = _atoms(value) | _atoms(argument)
    if len(atoms) != 1:
        return False
    (atom,) = atoms
    slopes = Slopes(atom, known)
    slope = fold(value, slopes)
    argument_slope = fold(argument, slopes)
    if slope is None or argument_slope is None:
        return False
    if "level" in (slope, argument_slope):
        return True
    return (slope if argument_slope == "rising" else OPPOSITE[slope]) == wanted


def _is_fixed(e: ir.Node) -> bool:
    """Returns whether an expression has one value throughout an episode."""
    if isinstance(e, ir.ParamRef | ir.Nowhere) or is_number_of_cells(e):
        return True
    has_only_parts = is_computed(e) or isinstance(e, ir.Arm)
    return has_only_parts and all(_is_fixed(child) for child in ir.children(e))


def _atoms(e: ir.Node) -> set[str]:
    """Returns the texts of the largest parts that read the state."""
    if _is_fixed(e):
        return set()
    if ir.is_expression(e) and not is_computed(e):
        return {text(e)}
    return {atom for child in ir.children(e) for atom in _atoms(child)}


@dataclass(frozen=True)
class Slopes(Analysis[Slope | None]):
    """Folds numbers to the direction in which they change when one expression grows.

    of: the text of that expression. The direction is None if it is not known. Every operation
    rounds, and a number that is larger is not smaller when it is rounded.
    """

    rules: ClassVar = {kind: BOUNDS[kind] for kind in (ir.Named, ir.Arithmetic)}
    of: str
    known: Sequence[Fact]

    def leaf(self, _e: ir.Expr) -> Slope | None:
        return None

    def refined(self, e: ir.Expr, result: Slope | None) -> Slope | None:
        if text(e) == self.of:
            return "rising"
        return "level" if _is_fixed(e) else result

    def calculated(self, e: ir.Arithmetic, slopes: list[Slope | None]) -> Slope | None:
        """Returns the direction of a calculation, from those of its arguments."""
        if not _is_as_computed(range_of(e)):
            return None
        parts = []
        for slope, part in zip(slopes, e.args, strict=True):
            if slope is None:
                return None
            parts.append(Moving(slope, range_of(part)))

        def is_less(one: int, other: int) -> bool:
            return compares(e.args[one], "<", e.args[other], self.known)

        return CALCULATIONS[e.fn].slope(parts, is_less)


def _is_as_computed(r: Range) -> bool:
    """Returns whether a result is what was computed: it doesn't wrap, and isn't infinite or NaN."""
    return (r.low, r.high) != INT32 if r.whole else r.sound
