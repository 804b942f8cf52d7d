"""Array values: a piece of Python text with the axes it has, and how pieces are combined.

Axes are named; an operation lines its operands up by name. An axis made later (of an inner sentence) stands further right.
"""

import operator
import re
from dataclasses import dataclass, replace

import numpy as np

DTYPES = {"f32": "jnp.float32", "i32": "jnp.int32", "u32": "jnp.uint32", "u8": "jnp.uint8", "bool": "bool"}
_COMPARISONS = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}
_OPERATIONS = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv, "%": operator.mod}
_OPPOSITES = (("==", "!="), ("!=", "=="))
_ATOM = re.compile(r"[A-Za-z_][A-Za-z0-9_.]*(\([^()]*\)|\[[^\[\]]*\])*|-?\d+(\.\d+)?(e-?\d+)?|0x[0-9a-f]+")


@dataclass(frozen=True)
class Axis:
    """One named axis; `order` is its place from left to right."""

    name: str
    size: int
    order: int


@dataclass(frozen=True)
class Value:
    """`text` computes an array with `axes`, then `levels` axes of words. dtype: f32, i32, u32, u8 (words), bool."""

    text: str
    dtype: str
    axes: tuple[Axis, ...] = ()
    levels: int = 0
    literal: bool = False


def literal(value: float | bool, dtype: str) -> Value:
    """Returns a number as text."""
    if dtype == "bool":
        return Value(repr(bool(value)), "bool", literal=True)
    return Value(repr(float(value)) if dtype == "f32" else repr(int(value)), dtype, literal=True)


def wrapped(value: Value) -> str:
    """Returns the text, in brackets unless it is one name, number, call or entry."""
    return value.text if _ATOM.fullmatch(value.text) else f"({value.text})"


def _in_operation(value: Value) -> str:
    """Returns the text as an operand: `~name` needs no brackets there, while in `~name.astype(…)` the `~` would come last."""
    is_negated = value.text.startswith("~") and _ATOM.fullmatch(value.text[1:])
    return value.text if is_negated else wrapped(value)


def union(*axes: tuple[Axis, ...]) -> tuple[Axis, ...]:
    """Returns all the axes, left to right."""
    return tuple(sorted({a for group in axes for a in group}, key=lambda a: a.order))


def aligned(value: Value, axes: tuple[Axis, ...]) -> str:
    """Returns the text of a value with an axis of length 1 for each of `axes` it lacks; scalars stay scalars."""
    if value.axes == axes or (not value.axes and not value.levels):
        return value.text
    index = [":" if a in value.axes else "None" for a in axes]
    return f"{wrapped(value)}[{', '.join(index)}]"


def as_dtype(value: Value, dtype: str) -> Value:
    """Returns the value converted; literals are written anew."""
    if value.dtype == dtype:
        return value
    if value.literal:
        return literal(float(value.text) if value.text not in ("True", "False") else value.text == "True", dtype)
    return replace(value, text=f"{wrapped(value)}.astype({DTYPES[dtype]})", dtype=dtype)


def binary(op: str, a: Value, b: Value, dtype: str) -> Value:
    """Returns `a op b`; of two literals a literal."""
    if a.literal and b.literal and op in _COMPARISONS:
        return literal(_COMPARISONS[op](float(a.text), float(b.text)), "bool")
    if a.literal and b.literal and op in _OPERATIONS and not (op in "/%" and not float(b.text)):
        number = np.float32 if dtype == "f32" else int
        return literal(_OPERATIONS[op](number(a.text), number(b.text)), dtype)
    axes = union(a.axes, b.axes)
    levels = max(a.levels, b.levels)
    left, right = (_operand(x, axes, levels) for x in (a, b))
    return Value(f"{left} {op} {right}", dtype, axes, levels)


def _operand(value: Value, axes: tuple[Axis, ...], levels: int) -> str:
    if value.literal or (not value.axes and not value.levels):
        return _in_operation(value)
    text = aligned(value, axes)
    if value.levels < levels:
        base = value if value.axes == axes else replace(value, text=text)
        return f"{wrapped(base)}[{', '.join([':'] * len(axes) + ['None'] * (levels - value.levels))}]"
    return _in_operation(replace(value, text=text))


def both(*conditions: Value | None) -> Value | None:
    """Returns the conjunction; None stands for always."""
    result: Value | None = None
    for c in conditions:
        if c is None or c.text == "True":
            continue
        if c.text == "False":
            return c
        result = c if result is None else binary("&", result, c, "bool")
    return result


def invert(condition: Value) -> Value:
    """Returns the negation."""
    if condition.literal:
        return literal(condition.text != "True", "bool")
    for op, opposite in _OPPOSITES:
        sides = condition.text.split(f" {op} ")
        if len(sides) == 2 and all(_ATOM.fullmatch(s) for s in sides):
            return replace(condition, text=f"{sides[0]} {opposite} {sides[1]}")
    if condition.text.startswith("~") and _ATOM.fullmatch(condition.text[1:]):
        return replace(condition, text=condition.text[1:])
    return replace(condition, text=f"~{wrapped(condition)}")


def select(condition: Value | None, a: Value, b: Value) -> Value:
    """Returns `a` where the condition holds, else `b`; both of one dtype."""
    if condition is None or condition.text == "True":
        return a
    if condition.text == "False":
        return b
    axes = union(condition.axes, a.axes, b.axes)
    levels = max(a.levels, b.levels, condition.levels)
    dtype = b.dtype if a.literal else a.dtype
    parts = ", ".join(_operand_plain(x, axes, levels) for x in (condition, a, b))
    if a.literal and b.literal and dtype != "bool":
        parts = f"{_operand_plain(condition, axes, levels)}, {DTYPES[dtype]}({a.text}), {DTYPES[dtype]}({b.text})"
    return Value(f"jnp.where({parts})", dtype, axes, levels)


def _operand_plain(value: Value, axes: tuple[Axis, ...], levels: int) -> str:
    text = _operand(value, axes, levels)
    return text[1:-1] if text.startswith("(") and text.endswith(")") and text[1:-1] == value.text else text


def reduce(fn: str, value: Value, over: tuple[Axis, ...]) -> Value:
    """Returns `any`, `all` or `sum` over axes; a value without an axis is the same all along it (`sum` multiplies)."""
    gone = tuple(a for a in over if a in value.axes)
    kept = tuple(a for a in value.axes if a not in gone)
    times = 1
    for axis in over:
        times *= 1 if axis in value.axes else axis.size
    if value.literal:
        number = as_dtype(value, "i32" if value.dtype == "bool" else value.dtype)
        return literal(float(number.text) * times, number.dtype) if fn == "sum" else value
    text, dtype = value.text, value.dtype
    if gone:
        where = [value.axes.index(a) for a in gone]
        everything = len(where) == len(value.axes) and not value.levels
        axis = "" if everything else f", axis={where[0] if len(where) == 1 else tuple(where)}"
        if fn == "sum":
            dtype = "i32" if value.dtype == "bool" else value.dtype
            text = f"jnp.sum({value.text}{axis}, dtype={DTYPES[dtype]})"
        else:
            text = f"jnp.{fn}({value.text}{axis})"
    result = Value(text, dtype, kept, value.levels, literal=value.literal)
    if fn == "sum" and times != 1:
        result = as_dtype(result, "i32") if dtype == "bool" else result
        return binary("*", result, literal(times, result.dtype), result.dtype)
    if fn == "sum" and dtype == "bool":
        return as_dtype(result, "i32")
    return result
