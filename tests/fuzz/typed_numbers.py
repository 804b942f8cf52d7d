"""Numbers of random programs with their intervals: combined, and fitted into limits."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.operations import CALCULATIONS
from tests.fuzz.reading import Typed


def fitted(value: Typed, low: float, high: float) -> str:
    """Returns the number brought into a range, if it might leave it."""
    text, type_ = value
    if type_.high > high:
        text = f"min({text}, {plain_number(high)})"
    if type_.low < low:
        text = f"max({text}, {plain_number(low)})"
    return text


def interval(fn: str, *of: ir.Type) -> tuple[float, float]:
    """Returns the interval of a calculation by those of numbers."""
    return CALCULATIONS[fn].interval(*((type_.low, type_.high) for type_ in of))


def plain_number(number: float) -> str:
    return str(int(number)) if number == int(number) else str(number)


def combined(op: str, left: Typed, right: Typed) -> Typed:
    (a, first), (b, second) = left, right
    low, high = interval(op, first, second)
    unit = first.unit if first.unit != "number" else second.unit
    if op == "*" and {first.unit, second.unit} - {"number"} and len({first.unit, second.unit}) == 2:
        unit = next(u for u in (*_ORDER, "number") if u in (first.unit, second.unit))
    both = "int" if first.kind == second.kind == "int" else "real"
    if both == "real" and unit in ("count", "steps", "cells"):
        unit = "number"
    if unit == "fraction" and (low < 0 or high > 1):
        unit = "number"
    right_text = b if is_simple(b) else f"({b})"
    left_text = a if op in "+-" or is_simple(a) else f"({a})"
    return f"{left_text} {op} {right_text}", ir.Type(kind=both, unit=unit, low=low, high=high)


_ORDER = ("reward", "probability", "fraction", "steps", "cells", "count")


def is_simple(text: str) -> bool:
    return text.replace("_", "a").replace(".", "a").isalnum()


def ends_of(value: Typed) -> tuple[float, float]:
    return value[1].low, value[1].high


def whole_type(low: float, high: float, unit: str) -> ir.Type:
    return ir.Type(kind="int", unit=unit, low=low, high=high)


def real_type(low: float, high: float, unit: str) -> ir.Type:
    return ir.Type(kind="real", unit=unit, low=low, high=high)
