"""Array values: an expression with the named axes it has, and how values are combined (broadcasting by name).

An operation lines its operands up by the names of their axes. An axis made later (of an inner statement) stands further right.
"""

import operator
from array import array
from dataclasses import replace
from math import prod
from typing import Literal as OneOf

from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.operations import COMPARISONS
from sjdsl.compiler.program.expressions import (
    ALL,
    NEW_AXIS,
    REST,
    Arange,
    Attribute,
    Binary,
    Broadcast,
    Cast,
    DType,
    Expression,
    Index,
    Literal,
    Name,
    Slice,
    Unary,
    Where,
    call,
    reduction,
    scalar,
)

_OPERATIONS = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "//": operator.floordiv,
    "%": operator.mod,
}
_OPPOSITES = {"==": "!=", "!=": "=="}


class Axis(Record):
    """One named axis; `order` is its place from left to right, `constant` the module's constant that is its size."""

    name: str
    size: int
    order: int
    constant: str = ""

    @property
    def extent(self) -> Literal:
        return Literal(self.size, self.constant)


class Value(Record):
    """`node` computes an array with `axes`, then `levels` axes: those of the entries of rows, last that of the words of large sets."""

    node: Expression
    dtype: DType
    axes: tuple[Axis, ...] = ()
    levels: int = 0

    @property
    def literal(self) -> bool:
        return isinstance(self.node, Literal)

    @property
    def number(self) -> float:
        """The number that a literal is."""
        assert isinstance(self.node, Literal) and isinstance(self.node.value, int | float)
        return self.node.value


def literal(value: float | bool, dtype: DType, name: str = "") -> Value:
    """Returns a number. `name`: the module's constant that it is printed as."""
    if dtype == "bool":
        return Value(Literal(bool(value)), "bool")
    return Value(Literal(float(value) if dtype == "f32" else int(value), name), dtype)


TRUE, FALSE = literal(True, "bool"), literal(False, "bool")


def float32(number: float) -> float:
    """Returns the float32 that is nearest to a number."""
    return array("f", [number])[0]


def iota(axis: Axis, dtype: DType = "i32") -> Value:
    """Returns 0, 1, … along an axis."""
    return Value(Arange(axis.extent, dtype), dtype, (axis,))


def one_hot(number: Value, axis: Axis) -> Value:
    """Returns where a number is that of a member along an axis, made later than its own axes."""
    if isinstance(number.node, Arange) and number.node.size == axis.extent:
        node = call("jnp.eye", axis.extent, dtype=Name("bool"))
    else:
        node = call("one_hot", number.node, axis.extent)
    return Value(node, "bool", (*number.axes, axis))


def union(*axes: tuple[Axis, ...]) -> tuple[Axis, ...]:
    """Returns all the axes, left to right."""
    return tuple(sorted({a for group in axes for a in group}, key=lambda a: a.order))


def aligned(value: Value, axes: tuple[Axis, ...], levels: int = 0) -> Expression:
    """Returns a value with an axis of length 1 for each of `axes` and `levels` that it lacks; scalars stay scalars."""
    lacking = max(0, levels - value.levels)
    if (value.axes == axes and not lacking) or not (value.axes or value.levels):
        return value.node
    return indexed(
        value.node, (*(ALL if a in value.axes else NEW_AXIS for a in axes), *[NEW_AXIS] * lacking)
    )


def indexed(node: Expression, keys: tuple[Expression | Slice, ...]) -> Expression:
    """Returns entries of an array; those of one that is converted are taken before they are, and new axes are added at once."""
    if isinstance(node, Cast):
        return Cast(indexed(node.value, keys), node.dtype, node.source)
    if isinstance(node, Index) and all(key in (ALL, NEW_AXIS) for key in node.keys):
        outer = tuple(ALL for _ in node.keys) + keys[1:] if keys[0] == REST else keys
        if all(key in (ALL, NEW_AXIS) for key in outer) and outer.count(ALL) == len(node.keys):
            inner = iter(node.keys)
            return Index(
                node.value, tuple(next(inner) if key == ALL else NEW_AXIS for key in outer)
            )
    return Index(node, keys)


def spread(value: Value, axes: tuple[Axis, ...]) -> Expression:
    """Returns a value spelt out over exactly these axes; a scalar over no axes stays one."""
    return (
        value.node
        if value.axes == axes
        else Broadcast(aligned(value, axes), tuple(a.extent for a in axes))
    )


def taken(value: Value, key: Expression, levels: int = 0) -> Value:
    """Returns the entry of a row that stands last, by a key that is the same for all."""
    return replace(value, node=indexed(value.node, (*[ALL] * len(value.axes), key)), levels=levels)


def as_dtype(value: Value, dtype: DType) -> Value:
    """Returns the value converted; literals are written anew."""
    if value.dtype == dtype:
        return value
    if isinstance(value.node, Literal):
        return literal(value.number, dtype, value.node.name)
    if (
        isinstance(value.node, Cast)
        and value.node.source in ("u8", "bool")
        and (value.dtype, dtype) == ("i32", "f32")
    ):
        return replace(value, node=Cast(value.node.value, dtype, value.node.source), dtype=dtype)
    return replace(value, node=Cast(value.node, dtype, value.dtype), dtype=dtype)


def binary(op: str, a: Value, b: Value, dtype: DType) -> Value:
    """Returns `a op b`; of two literals a literal, and nothing for what changes nothing."""
    if a.literal and b.literal and op in COMPARISONS:
        return literal(COMPARISONS[op].holds(a.number, b.number), "bool")
    if (
        a.literal
        and b.literal
        and op in _OPERATIONS
        and not (op in ("/", "//", "%") and not b.number)
    ):
        number = float32 if dtype == "f32" else int
        return literal(number(_OPERATIONS[op](number(a.number), number(b.number))), dtype)
    if op in _OPPOSITES and isinstance(a.node, Arange) and a.node == b.node and a.axes != b.axes:
        first, second = sorted((a, b), key=lambda value: value.axes[0].order)
        is_same = one_hot(first, second.axes[0])
        return is_same if op == "==" else invert(is_same)
    if op in COMPARISONS:
        a, b = _as_kept(a, b), _as_kept(b, a)
    if _is_neutral(op, b) and a.dtype == dtype:
        return a
    if op in "+*" and _is_neutral(op, a) and b.dtype == dtype:
        return b
    axes = union(a.axes, b.axes)
    levels = max(a.levels, b.levels)
    left, right = (aligned(x, axes, levels) for x in (a, b))
    return Value(joined(op, left, right), dtype, axes, levels)


def joined(op: str, left: Expression, right: Expression) -> Expression:
    """Returns an operation; a & (b & c) is (a & b) & c, and a + -1 is a - 1."""
    match right:
        case Binary(op=inner) if inner == op and op in "&|":
            return Binary(op, joined(op, left, right.left), right.right)
        case Literal(value=int() | float() as number, name="") if op == "+" and number < 0:
            return Binary("-", left, Literal(-number))
        case _:
            return Binary(op, left, right)


def _as_kept(value: Value, other: Value) -> Value:
    """Returns what is kept without its conversion: a byte that is compared with what a byte can be, a word kept in an integer."""
    match value.node, other.node:
        case Cast(value=Attribute() as word, dtype="u8", source="i32"), Literal():
            return replace(value, node=word, dtype="i32")
        case Cast(value=byte, dtype="i32", source="u8"), Literal(value=int(number)) if (
            0 <= number <= 255
        ):
            return replace(value, node=byte, dtype="u8")
        case Cast(value=byte, dtype="i32", source="u8"), Cast(dtype="i32", source="u8"):
            return replace(value, node=byte, dtype="u8")
        case _:
            return value


def _is_neutral(op: str, value: Value) -> bool:
    """Whether a literal changes nothing as the right operand. (x + 0.0 is not x: it has no negative zero.)"""
    if not value.literal:
        return False
    neutral = {"+": 0, "-": 0, "*": 1, "<<": 0, ">>": 0, "|": 0}.get(op)
    return (
        neutral is not None
        and value.number == neutral
        and value.dtype != "bool"
        and (value.dtype != "f32" or op == "*")
    )


def both(*conditions: Value) -> Value:
    """Returns the conjunction."""
    result = TRUE
    for condition in conditions:
        if condition == FALSE:
            return FALSE
        if condition != TRUE:
            result = condition if result == TRUE else binary("&", result, condition, "bool")
    return result


def either(tests: list[Value]) -> Value:
    """Returns the disjunction."""
    if TRUE in tests:
        return TRUE
    result, *rest = [t for t in tests if t != FALSE] or [FALSE]
    for test in rest:
        result = binary("|", result, test, "bool")
    return result


def invert(condition: Value) -> Value:
    """Returns the negation."""
    match condition.node:
        case Literal(value=value):
            return literal(not value, "bool")
        case Binary(op=("==" | "!=") as op, left=left, right=right):
            return replace(condition, node=Binary(_OPPOSITES[op], left, right))
        case Unary(op="~", operand=operand):
            return replace(condition, node=operand)
        case _:
            return replace(condition, node=Unary("~", condition.node))


def select(condition: Value, a: Value, b: Value) -> Value:
    """Returns `a` where the condition holds, else `b`; both of one dtype."""
    if condition == TRUE:
        return a
    if condition == FALSE:
        return b
    axes = union(condition.axes, a.axes, b.axes)
    levels = max(a.levels, b.levels, condition.levels)
    dtype = b.dtype if a.literal else a.dtype
    test, then, otherwise = (aligned(x, axes, levels) for x in (condition, a, b))
    if a.literal and b.literal and dtype != "bool":
        if dtype != "f32" and (a.number, b.number) == (
            1,
            0,
        ):  # 1 where it holds: the condition as a number
            return Value(Cast(test, dtype), dtype, axes, levels)
        then, otherwise = scalar(then, dtype), scalar(otherwise, dtype)
    return Value(Where(test, then, otherwise), dtype, axes, levels)


def reduce(
    fn: OneOf["any", "all", "sum", "min", "max"], value: Value, over: tuple[Axis, ...]
) -> Value:
    """Returns `any`, `all`, `sum`, `min` or `max` over axes; a value without an axis is the same all along it (`sum` multiplies)."""
    gone = tuple(a for a in over if a in value.axes)
    times = prod(a.size for a in over if a not in value.axes)
    if value.literal:
        number = as_dtype(value, "i32" if value.dtype == "bool" else value.dtype)
        return (
            binary("*", number, literal(times, number.dtype), number.dtype)
            if fn == "sum"
            else value
        )
    result = value
    if gone:
        where = tuple(value.axes.index(a) for a in gone)
        everything = len(where) == len(value.axes) and not value.levels
        counts = fn == "sum" and value.dtype == "bool"
        dtype: DType = "i32" if counts else value.dtype
        node = reduction(
            "count" if counts else fn,
            summed(value.node, dtype) if fn == "sum" else value.node,
            None if everything else where,
            dtype if fn == "sum" and not counts else None,
        )
        result = Value(node, dtype, tuple(a for a in value.axes if a not in gone), value.levels)
    if fn != "sum":
        return result
    result = as_dtype(result, "i32") if result.dtype == "bool" else result
    return binary("*", result, literal(times, result.dtype), result.dtype)


def summed(node: Expression, dtype: DType) -> Expression:
    """Returns what is summed up in a dtype: the sum converts it itself."""
    return node.value if isinstance(node, Cast) and node.dtype == dtype else node
