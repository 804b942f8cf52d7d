"""Values of expressions, and whether conditions hold, as far as that is known without playing.

Whole numbers are exact. Reals are rounded to float32 at each step, as in play, so that what a
`require` says of them holds there, too.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.equivalence import is_exact
from sjdsl.compiler.ir.fold import VALUES, Analysis, UnknownValue, fold
from sjdsl.compiler.ir.operations import CALCULATIONS, COMPARISONS
from sjdsl.compiler.ir.range_arithmetic import nearest

TOLERANCE = 1e-6  # parameters are float32: `a + b == 1` must survive rounding


@dataclass(frozen=True)
class Evaluation(Analysis[Any]):
    """Folds expressions to values.

    Words to texts, agents to numbers, nobody and nowhere to None, rows to tuples, sets to sets.

    read: returns the value of a parameter or a field. Raises UnknownValue.
    computes_reals: if not, what is computed of reals isn't known: play may round it otherwise.
    tolerance: the relative difference of reals that count as equal.
    """

    rules = VALUES
    read: Callable[[ir.Expr], Any]
    computes_reals: bool = True
    tolerance: float = 0.0

    def leaf(self, e: ir.Expr) -> Any:
        return self.read(e)

    def rounded(self, real: float) -> float:
        """Returns a real that is computed, as float32. Raises UnknownValue."""
        if not self.computes_reals:
            raise UnknownValue
        return nearest(real)

    def calculated(self, e: ir.Arithmetic, *numbers: float) -> float:
        """Returns what a calculation makes of numbers. Raises UnknownValue."""
        if any(part.type.kind == "real" for part in (e, *e.args)):
            numbers = tuple(map(nearest, numbers))
        result = CALCULATIONS[e.fn].fold(*numbers)
        return self.rounded(result) if e.type.kind == "real" else result

    def compares(self, e: ir.Expr, fn: ir.Comparison, left: ir.Expr, right: ir.Expr) -> bool:
        """Returns whether a comparison, `e` or a part of it, holds. Raises UnknownValue."""
        a = fold(left, self)
        b = fold(right, self)
        if not is_exact(e):
            a = nearest(a)
            b = nearest(b)
        is_equal = abs(a - b) <= self._tolerance(e) * max(1.0, abs(a), abs(b))
        return bool(COMPARISONS[fn].holds(a, a if is_equal else b))

    def _tolerance(self, e: ir.Expr) -> float:
        """Returns the tolerance of a comparison: 0 if a whole number in it can vary."""
        types = [part.type for part in ir.children(e) if ir.is_expression(part)]
        whole = [type_ for type_ in types if type_.kind == "int"]
        varying = any(type_.low < type_.high for type_ in whole)
        return 0.0 if varying or len(whole) == len(types) else self.tolerance


def holds(test: ir.Expr, params: Mapping[str, Any]) -> bool:
    """Returns whether a `require` holds for these parameters; tables are nested tuples."""

    def read(e: ir.Expr) -> Any:
        assert isinstance(e, ir.ParamRef), e
        return params[e.name]

    return bool(fold(test, Evaluation(read, tolerance=TOLERANCE)))


def decided(test: ir.Expr, analysis: Analysis[Any]) -> bool | None:
    """Returns whether a condition holds; None if that is not known."""
    try:
        return bool(fold(test, analysis))
    except UnknownValue:
        return None
