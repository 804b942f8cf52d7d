"""Types of the language as values: units, intervals, and what arithmetic does to them."""

from math import inf

from sjdsl.compiler import ir

# By how much reals may pass the ends of their intervals, relative: the interpreter allows as much.
SLACK = 1e-5
INTEGER_UNITS = ("count", "steps", "cells")
UNIT_LIMITS = {
    "count": (0, inf),
    "steps": (0, inf),
    "cells": (0, inf),
    "reward": (-inf, inf),
    "probability": (0.0, 1.0),
    "fraction": (0.0, 1.0),
    "number": (-inf, inf),
}


def integer(low: float, high: float, unit: ir.Unit = "count") -> ir.Type:
    """Returns the type of the integers `low` .. `high`."""
    return ir.Type(kind="int", unit=unit, low=low, high=high)


def real(low: float, high: float, unit: ir.Unit = "number") -> ir.Type:
    """Returns the type of the reals `low` .. `high`."""
    return ir.Type(kind="real", unit=unit, low=low, high=high)


def words(names: tuple[str, ...]) -> ir.Type:
    """Returns the type of one of the words."""
    return ir.Type(kind="word", words=names)


def element(row: ir.Type) -> ir.Type:
    """Returns the type of one entry of a row or table."""
    return row.changed(indexed_by=row.indexed_by[1:])


def is_number(type_: ir.Type) -> bool:
    """Returns whether values are single numbers."""
    return type_.is_single("int", "real")


def has_limits(type_: ir.Type) -> bool:
    """Returns whether numbers have a least and a greatest value."""
    return type_.low > -inf and type_.high < inf


def describe(type_: ir.Type) -> str:
    """Returns what an author would call values of this type."""
    if type_.indexed_by:
        entries = {"word": "words", "int": "numbers", "real": "numbers"}.get(type_.kind, "values")
        return f"a row of {entries} by {type_.indexed_by[0]}"
    match type_.kind:
        case "word":
            if len(type_.words) == 1:
                return f"the word `{type_.words[0]}`"
            return f"a word of {{ {', '.join(type_.words)} }}"
        case "int" | "real":
            plural = "counts" if type_.unit == "count" else type_.unit
            return f"a number of {plural}" if type_.unit in INTEGER_UNITS else f"a {type_.unit}"
        case "cell" if type_.kinds:
            return f"a cell of {' or '.join(type_.kinds)}"
    kinds = {
        "condition": "a condition",
        "agent": "an agent",
        "agents": "a set of agents",
        "mix": "a mix of words",
    }
    return {**kinds, "cell": "a cell", "member": "an agent or a cell"}[type_.kind]


def join_units(left: ir.Unit, right: ir.Unit) -> ir.Unit | None:
    """Returns the unit two numbers share when added or compared; a bare number takes the other's.

    None: they do not mix.
    """
    if left == right or right == "number":
        return left
    if left == "number":
        return right
    return None


def times_unit(left: ir.Unit, right: ir.Unit) -> ir.Unit | None:
    """Returns the unit of a product: a number or a count scales anything.

    Shares scale rewards and chances.
    """
    if "number" in (left, right):
        return right if left == "number" else left
    for a, b in ((left, right), (right, left)):
        if a == "count":
            return b
        if a == "fraction" and b in ("reward", "probability", "fraction"):
            return b
        if a == "probability" and b in ("reward", "probability"):
            return b
    return None


def over_unit(left: ir.Unit, right: ir.Unit) -> ir.Unit | None:
    """Returns the unit of a quotient.

    Like over like is a bare number, anything over a number or a count keeps its unit.
    """
    if left == right and right != "number":
        return "number"
    if right in ("number", "count"):
        return left
    return None


def hull(types: list[ir.Type]) -> tuple[float, float]:
    """Returns the smallest interval that holds all the types' intervals."""
    return min(t.low for t in types), max(t.high for t in types)


def without_zero(divisor: ir.Type) -> ir.Type:
    """Returns the type of a divisor that is known not to be 0.

    A whole number that begins or ends there begins or ends beside it.
    """
    if divisor.kind != "int":
        return divisor
    low = 1 if divisor.low == 0 else divisor.low
    high = -1 if divisor.high == 0 else divisor.high
    return divisor.changed(low=low, high=high) if low <= high else divisor


def times(x: float, y: float) -> float:
    """Returns the product of two ends of intervals; nothing of something endless is nothing."""
    return 0 if x == 0 or y == 0 else x * y
