"""Array values with named axes, and how they are combined (broadcasting by name).

An operation lines its operands up by the names of their axes. Axes are in the order in which they
were made, those of outer statements first.
"""

import operator
from array import array
from collections.abc import Callable
from dataclasses import replace
from math import prod
from typing import Literal as OneOf
from typing import TypeAlias

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
    Part,
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
_NEUTRAL = {"+": 0, "-": 0, "*": 1, "<<": 0, ">>": 0, "|": 0}


class Axis(Record):
    """A named axis.

    order: its place from left to right. constant: the module's constant that is its size, if any.
    """

    name: str
    size: int
    order: int
    constant: str = ""

    @property
    def extent(self) -> Literal:
        return Literal(self.size, self.constant)


def _operator(op: str) -> Callable[["Value", "Operand"], "Value"]:
    return lambda left, right: binary(op, left, as_value(right, left.dtype))


class Value(Record):
    """An expression of generated code that computes an array, with the names of its axes.

    `actions[:, None] == ACTION_ZAP` over the axes (zapper, victim) has shape `[N, 1]`: a value need
    not be as long as an axis along which it is always the same. Operators align their operands by
    the names of axes: `a + b` is over all axes that either has.

    node: the expression. axes: of its first dimensions. row_dims: how many dimensions come after
      them: one for each index set of a row or table, and one more for sets of more than 32 agents,
      which take several numbers.

    `==` says whether two values are the same expression; `eq` and `ne` compare entry by entry.
    """

    node: Expression
    dtype: DType
    axes: tuple[Axis, ...] = ()
    row_dims: int = 0

    __add__ = _operator("+")
    __sub__ = _operator("-")
    __mul__ = _operator("*")
    __floordiv__ = _operator("//")
    __mod__ = _operator("%")
    __and__ = _operator("&")
    __or__ = _operator("|")
    __lshift__ = _operator("<<")
    __rshift__ = _operator(">>")
    __lt__ = _operator("<")
    __le__ = _operator("<=")
    __gt__ = _operator(">")
    __ge__ = _operator(">=")
    eq = _operator("==")
    ne = _operator("!=")

    def __invert__(self) -> "Value":
        """Returns the opposite of a condition, in the simplest form."""
        match self.node:
            case Literal(value=value):
                return literal(not value, "bool")
            case Binary(op=("==" | "!=") as op, left=left, right=right):
                return replace(self, node=Binary(_OPPOSITES[op], left, right))
            case Unary(op="~", operand=operand):
                return replace(self, node=operand)
            case _:
                return replace(self, node=~self.node)

    @property
    def literal(self) -> bool:
        return isinstance(self.node, Literal)

    @property
    def array(self) -> "Value":
        """This value; a literal as an array, `jnp.int32(1)` for 1."""
        return replace(self, node=scalar(self.node, self.dtype)) if self.literal else self

    @property
    def number(self) -> float:
        """The number that a literal is."""
        assert isinstance(self.node, Literal) and isinstance(self.node.value, int | float)
        return self.node.value


Axes: TypeAlias = tuple[Axis, ...]
Operand: TypeAlias = Value | float | Literal


def literal(value: float | bool, dtype: DType, name: str = "") -> Value:
    """Returns a number. name: the module's constant that it is printed as."""
    match dtype:
        case "bool":
            return Value(Literal(bool(value)), "bool")
        case "f32":
            return Value(Literal(float(value), name), dtype)
        case _:
            return Value(Literal(int(value), name), dtype)


TRUE = literal(True, "bool")
FALSE = literal(False, "bool")


def as_value(operand: Operand, dtype: DType) -> Value:
    """Returns a number, or a number that the module names, as a value of a dtype."""
    match operand:
        case Value():
            return operand
        case Literal():
            return Value(operand, dtype)
        case _:
            return literal(operand, dtype)


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


def union(*axes: Axes) -> Axes:
    """Returns all the axes, left to right."""
    distinct = set[Axis]().union(*axes)
    return tuple(sorted(distinct, key=lambda axis: axis.order))


def axes_of(*values: Value | None) -> Axes:
    """Returns the axes of all the values, left to right."""
    return union(*(value.axes for value in values if value is not None))


def without(axes: Axes, others: Axes) -> Axes:
    """Returns the axes that are not among others."""
    return tuple(axis for axis in axes if axis not in others)


def common(axes: Axes, others: Axes) -> Axes:
    """Returns the axes that are also among others."""
    return tuple(axis for axis in axes if axis in others)


def size_of(axes: Axes) -> int:
    """Returns how many entries an array over these axes has."""
    return prod(axis.size for axis in axes)


def aligned(value: Value, axes: Axes, row_dims: int = 0) -> Expression:
    """Returns the array of a value with a dimension for each of `axes`, and `row_dims` more.

    Those that it lacks have length 1, so that NumPy's broadcasting does the rest. Scalars stay
    scalars.
    """
    if not value.axes and not value.row_dims:
        return value.node
    lacking = max(0, row_dims - value.row_dims)
    if value.axes == axes and not lacking:
        return value.node
    return indexed(value.node, (*_keys(value, axes), *[NEW_AXIS] * lacking))


def row_aligned(row: Value, axes: Axes) -> Expression:
    """Returns a row with an axis of length 1 for each of `axes` that it lacks, its entries last."""
    return row.node if row.axes == axes else Index(row.node, _keys(row, axes))


def _keys(value: Value, axes: Axes) -> tuple[Slice | Literal, ...]:
    return tuple(ALL if axis in value.axes else NEW_AXIS for axis in axes)


def indexed(node: Expression, keys: tuple[Expression | Slice, ...]) -> Expression:
    """Returns `node[keys]` in its simplest form.

    Entries are taken before they are converted, and `x[:, None][:, :, None]` is `x[:, None, None]`.
    """
    if isinstance(node, Cast):
        return Cast(indexed(node.value, keys), node.dtype, node.source)
    if isinstance(node, Index):
        both = _keys_in_one(node.keys, keys)
        if both is not None:
            return Index(node.value, both)
    return Index(node, keys)


def _keys_in_one(
    first: tuple[Expression | Slice, ...], second: tuple[Expression | Slice, ...]
) -> tuple[Expression | Slice, ...] | None:
    """Returns the keys that do what `x[first][second]` does; None unless both only add axes."""
    if second[0] == REST:
        second = (*[ALL] * len(first), *second[1:])
    adds_axes = all(key in (ALL, NEW_AXIS) for key in (*first, *second))
    if not adds_axes or second.count(ALL) != len(first):
        return None
    unused = iter(first)
    return tuple(next(unused) if key == ALL else NEW_AXIS for key in second)


def spread(value: Value, axes: Axes) -> Expression:
    """Returns the array of a value at the full length of exactly these axes."""
    if value.axes == axes:
        return value.node
    return Broadcast(aligned(value, axes), tuple(a.extent for a in axes))


def broadcast(value: Value, axes: Axes) -> Value:
    """Returns what `spread` does, as a value."""
    return replace(value, node=spread(value, axes), axes=axes)


def called(kernel: str, *arguments: Value | Part, dtype: DType | None = None) -> Value:
    """Returns `kernel(*arguments)`, computed entry by entry; arguments are aligned first.

    dtype: of the result; that of the first argument if None.
    """
    first = arguments[0]
    assert isinstance(first, Value)
    axes = axes_of(*(argument for argument in arguments if isinstance(argument, Value)))
    nodes: list[Part] = []
    for argument in arguments:
        nodes.append(aligned(argument, axes) if isinstance(argument, Value) else argument)
    return Value(call(kernel, *nodes), dtype or first.dtype, axes, first.row_dims)


def looked_up(table: Expression, key: Value, dtype: DType) -> Value:
    """Returns `table[key]`, where `table` is a constant of the module, of one dimension."""
    return Value(table[key.node], dtype, key.axes)


def taken(value: Value, key: Expression, row_dims: int = 0) -> Value:
    """Returns entry `key` of each row, along its first dimension. row_dims: of the entry."""
    return replace(
        value, node=indexed(value.node, (*[ALL] * len(value.axes), key)), row_dims=row_dims
    )


def as_dtype(value: Value, dtype: DType) -> Value:
    """Returns the value converted; a literal becomes another literal."""
    if value.dtype == dtype:
        return value
    node = value.node
    if isinstance(node, Literal):
        return literal(value.number, dtype, node.name)
    if isinstance(node, Cast) and node.source in ("u8", "bool"):
        if node.source == dtype:  # what has been widened
            return replace(value, node=node.value, dtype=dtype)
        if (value.dtype, dtype) == ("i32", "f32"):  # at once, not by way of int32
            return replace(value, node=Cast(node.value, dtype, node.source), dtype=dtype)
    return replace(value, node=Cast(node, dtype, value.dtype), dtype=dtype)


def binary(op: str, a: Value, b: Value) -> Value:
    """Returns `a op b`, computed if both are literals, without an operand that changes nothing."""
    if op in "&|" and a.dtype == "bool":
        neutral, absorbing = (TRUE, FALSE) if op == "&" else (FALSE, TRUE)
        if absorbing in (a, b):
            return absorbing
        if neutral in (a, b):
            return b if a == neutral else a
    dtype: DType = "bool" if op in COMPARISONS else a.dtype
    if a.literal and b.literal:
        result = _folded(op, a.number, b.number, dtype)
        if result is not None:
            return result
    # Members along two axes, each with each: whether they are the same one.
    if op in _OPPOSITES and isinstance(a.node, Arange) and a.node == b.node and a.axes != b.axes:
        first, second = sorted((a, b), key=lambda value: value.axes[0].order)
        is_same = one_hot(first, second.axes[0])
        return is_same if op == "==" else ~is_same
    # Numbers compare as they are stored, without their conversions.
    if op in COMPARISONS:
        as_stored = _before_conversion(a, b)
        b = _before_conversion(b, a)
        a = as_stored
    elif _is_neutral(op, b):
        return a
    elif op in "+*" and _is_neutral(op, a):
        return b
    axes = union(a.axes, b.axes)
    row_dims = max(a.row_dims, b.row_dims)
    left = aligned(a, axes, row_dims)
    right = aligned(b, axes, row_dims)
    return Value(joined(op, left, right), dtype, axes, row_dims)


def _folded(op: str, a: float, b: float, dtype: DType) -> Value | None:
    """Returns the result of an operation on two literals; None if it isn't known here."""
    if op in COMPARISONS:
        return literal(COMPARISONS[op].holds(a, b), "bool")
    if op not in _OPERATIONS or (op in ("/", "//", "%") and not b):
        return None
    number = float32 if dtype == "f32" else int
    return literal(number(_OPERATIONS[op](number(a), number(b))), dtype)


def joined(op: str, left: Expression, right: Expression) -> Expression:
    """Returns `left op right`, with a & (b & c) as (a & b) & c, and a + -1 as a - 1."""
    match right:
        case Binary(op=inner) if inner == op and op in "&|":
            return Binary(op, joined(op, left, right.left), right.right)
        case Literal(value=int() | float() as number, name="") if op == "+" and number < 0:
            return Binary("-", left, Literal(-number))
        case _:
            return Binary(op, left, right)


def _before_conversion(value: Value, other: Value) -> Value:
    """Returns an operand of a comparison as it is stored, if the conversion makes no difference.

    Such are a byte that is compared with a byte, and a word of an enum stored as int32.
    """
    match value.node, other.node:
        case Cast(value=Attribute() as stored, dtype="u8", source="i32"), Literal():
            return replace(value, node=stored, dtype="i32")
        case Cast(value=byte, dtype="i32", source="u8"), Literal(value=int(number)) if (
            0 <= number <= 255
        ):
            return replace(value, node=byte, dtype="u8")
        case Cast(value=byte, dtype="i32", source="u8"), Cast(dtype="i32", source="u8"):
            return replace(value, node=byte, dtype="u8")
        case _:
            return value


def _is_neutral(op: str, value: Value) -> bool:
    """Returns whether a literal changes nothing as the right operand."""
    if not value.literal or value.dtype == "bool":
        return False
    if value.dtype == "f32" and op != "*":  # x + 0.0 is not x for the negative zero
        return False
    return value.number == _NEUTRAL.get(op)


def select(condition: Value, a: Operand, b: Operand) -> Value:
    """Returns `a` where the condition holds, else `b`; numbers are of the other one's dtype."""
    if not isinstance(a, Value):
        assert isinstance(b, Value)
        a = as_value(a, b.dtype)
    b = as_value(b, a.dtype)
    if condition == TRUE:
        return a
    if condition == FALSE:
        return b
    axes = union(condition.axes, a.axes, b.axes)
    row_dims = max(a.row_dims, b.row_dims, condition.row_dims)
    dtype = b.dtype if a.literal else a.dtype
    test = aligned(condition, axes, row_dims)
    then = aligned(a, axes, row_dims)
    otherwise = aligned(b, axes, row_dims)
    if a.literal and b.literal and dtype != "bool":
        if dtype != "f32" and (a.number, b.number) == (1, 0):  # the condition as a number
            return Value(Cast(test, dtype), dtype, axes, row_dims)
        then = scalar(then, dtype)
        otherwise = scalar(otherwise, dtype)
    return Value(Where(test, then, otherwise), dtype, axes, row_dims)


def reduce(fn: OneOf["any", "all", "sum", "min", "max"], value: Value, over: Axes) -> Value:
    """Returns `any`, `all`, `sum`, `min` or `max` over axes; a sum of booleans counts them.

    A value without one of the axes is the same all along it, so its sum is multiplied.
    """
    varying = common(over, value.axes)
    result = _reduced(fn, value, varying) if varying else value
    if fn != "sum":
        return result
    if result.dtype == "bool":
        result = as_dtype(result, "i32")
    return result * size_of(without(over, value.axes))


def _reduced(fn: OneOf["any", "all", "sum", "min", "max"], value: Value, over: Axes) -> Value:
    """Returns the reduction of a value over axes that it has."""
    axes = without(value.axes, over)
    places: tuple[int, ...] | None = tuple(value.axes.index(axis) for axis in over)
    if not axes and not value.row_dims:
        places = None  # all there are
    if fn != "sum":
        return replace(value, node=reduction(fn, value.node, places), axes=axes)
    if value.dtype == "bool":
        node = reduction("count", summed(value.node, "i32"), places)
        return replace(value, node=node, dtype="i32", axes=axes)
    node = reduction("sum", summed(value.node, value.dtype), places, value.dtype)
    return replace(value, node=node, axes=axes)


def summed(node: Expression, dtype: DType) -> Expression:
    """Returns the operand of a sum, without a conversion to the dtype of the sum."""
    return node.value if isinstance(node, Cast) and node.dtype == dtype else node
