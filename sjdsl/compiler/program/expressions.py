"""Expressions and statements of an array program: frozen nodes, which `lower` builds and only `emit` turns into text.

Two expressions are equal if they compute the same; the name that a literal is printed under does not matter to that.
"""

from __future__ import annotations

from collections.abc import Callable
from types import EllipsisType
from typing import Any, TypeAlias
from typing import Literal as OneOf

from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.diagnostics.tree import TreeNode, walk

DType: TypeAlias = OneOf["f32", "i32", "u32", "u8", "bool"]


class Node(Record, TreeNode["Node"]):
    """A part of a program."""


def _operator(op: str) -> Callable[[Computed, Part], Binary]:
    def binary(left: Any, right: Part) -> Binary:
        return Binary(op, left, constant(right))

    return binary


class Computed(Node):
    """A node that computes a value. Operators make nodes of it: `a + 1` is `Binary("+", a, Literal(1))`.

    `==` tells whether two nodes are the same; `eq` and `ne` compare what they compute.
    Keys in brackets are written as NumPy's: `a[:, None]`.
    """

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
    __gt__ = _operator(">")
    __ge__ = _operator(">=")
    eq = _operator("==")
    ne = _operator("!=")

    def __invert__(self) -> Unary:
        return Unary("~", self)  # type: ignore[arg-type]

    def __getitem__(self, keys: Any) -> Index:
        keys = keys if isinstance(keys, tuple) else (keys,)
        return Index(self, tuple(map(_key, keys)))  # type: ignore[arg-type]

    __iter__ = None  # otherwise Python would iterate by the keys 0, 1, ...


def _key(key: Any) -> Expression | Slice:
    """Returns a Python key as a node."""
    if not isinstance(key, slice):
        return constant(key)
    start = None if key.start is None else constant(key.start)
    stop = None if key.stop is None else constant(key.stop)
    return Slice(start, stop)


class Name(Computed):
    """A variable of a function, a constant of the module, a kernel, or what is imported."""

    identifier: str


class Literal(Computed):
    """A number, truth, text, None (in an index: a new axis) or `...`. `name`: the module's constant that has this value."""

    value: bool | int | float | str | EllipsisType | None
    name: str = ""

    @property
    def size(self) -> int:
        """The whole number that a literal is."""
        assert isinstance(self.value, int)
        return self.value

    def __eq__(self, other: object) -> bool:  # 1, 1.0 and True differ
        """Compares types too."""
        return (
            isinstance(other, Literal)
            and type(self.value) is type(other.value)
            and self.value == other.value
        )

    def __hash__(self) -> int:
        return hash((type(self.value), self.value))


class Attribute(Computed):
    """`value.name`."""

    value: Expression
    name: str


class Call(Computed):
    """`function(arguments, keyword=argument, …)`."""

    function: Expression
    arguments: tuple[Expression, ...] = ()
    keywords: tuple[tuple[str, Expression], ...] = ()


class Slice(Node):
    """`start:stop` in an index."""

    start: Expression | None = None
    stop: Expression | None = None


class Index(Computed):
    """`value[keys]`."""

    value: Expression
    keys: tuple[Expression | Slice, ...]


class Unary(Computed):
    """`~operand` or `-operand`."""

    op: str
    operand: Expression


class Binary(Computed):
    """An operation or comparison of two arrays, entry by entry."""

    op: str
    left: Expression
    right: Expression


class Where(Computed):
    """`then` where the condition holds, else `otherwise`."""

    condition: Expression
    then: Expression
    otherwise: Expression


class Cast(Computed):
    """An array in another dtype. `source`: what it was, if that is known."""

    value: Expression
    dtype: DType
    source: DType | None = None


class Broadcast(Computed):
    """An array spread out to a shape."""

    value: Expression
    shape: tuple[Expression, ...]


class Arange(Computed):
    """0, 1, … along an axis."""

    size: Expression
    dtype: DType | None = None


class Sequence(Computed):
    """A tuple, or a list."""

    items: tuple[Expression, ...]
    is_list: bool = False


class Mapping(Computed):
    """A dictionary with texts for keys."""

    entries: tuple[tuple[str, Expression], ...]


class Lambda(Computed):
    """A function of its parameters."""

    parameters: tuple[str, ...]
    body: Expression


OfArrays: TypeAlias = Unary | Binary | Where | Cast | Broadcast | Arange
Expression: TypeAlias = (
    Name | Literal | Attribute | Call | Index | OfArrays | Sequence | Mapping | Lambda
)
Part: TypeAlias = Expression | bool | int | float


class Assign(Node):
    """Gives names to a value; several take it apart. `origin`: the line of the `.sj` file it comes from."""

    names: tuple[str, ...]
    value: Expression
    origin: Span | None = None


class Return(Node):
    """Ends a function; several values are a tuple."""

    values: tuple[Expression, ...]
    origin: Span | None = None


Statement: TypeAlias = Assign | Return

ALL = Slice()
NEW_AXIS = Literal(None)
REST = Literal(...)


def call(function: str, *arguments: object, **keywords: object) -> Call:
    """Returns a call of a kernel, or of a method or function with a path such as `jnp.concatenate`.

    Arguments are nodes, or what `constant` makes nodes of.
    """
    named = tuple((name, constant(value)) for name, value in keywords.items())
    return Call(path(function), tuple(map(constant, arguments)), named)


def path(dotted: str) -> Expression:
    """Returns the expression of a name with attributes, such as `state.position`."""
    first, *rest = dotted.split(".")
    found: Expression = Name(first)
    for name in rest:
        found = Attribute(found, name)
    return found


DTYPES: dict[DType, Expression] = {
    "f32": path("jnp.float32"),
    "i32": path("jnp.int32"),
    "u32": path("jnp.uint32"),
    "u8": path("jnp.uint8"),
    "bool": Name("bool"),
}


def reduction(
    fn: OneOf["any", "all", "count", "sum", "min", "max", "argmax"],
    value: Expression,
    axes: tuple[int, ...] | None = None,
    dtype: DType | None = None,
) -> Call:
    """Returns a reduction over some axes, over all of them if none are named. `dtype`: of a sum."""
    keywords: dict[str, Expression] = {}
    if axes is not None:
        keywords["axis"] = constant(axes[0] if len(axes) == 1 else axes)
    if dtype is not None:
        keywords["dtype"] = DTYPES[dtype]
    return call(f"{fn}_of", value, **keywords)


def written(
    kernel: OneOf["set_at", "add_at"],
    target: Expression,
    places: tuple[Expression, ...],
    value: Expression,
) -> Call:
    """Returns an array with values set or added at places; those past the end change nothing."""
    return call(kernel, target, places[0] if len(places) == 1 else Sequence(places), value)


def as_array(value: object, dtype: DType | None = None) -> Call:
    """Returns numbers as an array."""
    if dtype is None:
        return call("jnp.asarray", value)
    return call("jnp.asarray", value, DTYPES[dtype])


def scalar(value: Expression, dtype: DType) -> Call:
    """Returns a number with its dtype, such as `jnp.int32(1)`."""
    return Call(DTYPES[dtype], (value,))


def constant(value: object) -> Expression:
    """Returns numbers, texts, tuples, lists and dictionaries as they are written; nodes stay."""
    match value:
        case Node():
            return value  # type: ignore[return-value]
        case tuple() | list():
            return Sequence(tuple(map(constant, value)), isinstance(value, list))
        case dict():
            return Mapping(tuple((key, constant(entry)) for key, entry in value.items()))
        case _:
            assert value is None or isinstance(value, bool | int | float | str | EllipsisType)
            return Literal(value)


def shape_of(sizes: tuple[Expression, ...]) -> Expression:
    """Returns a shape as an argument: a number for one axis, else a tuple."""
    return sizes[0] if len(sizes) == 1 else Sequence(sizes)


def zeros(dtype: DType, *sizes: Part) -> Call:
    """Returns an array of zeros."""
    return call("jnp.zeros", shape_of(tuple(map(constant, sizes))), DTYPES[dtype])


def concatenated(parts: list[Expression]) -> Expression:
    """Returns arrays one after another; one alone as it is."""
    return parts[0] if len(parts) == 1 else call("jnp.concatenate", parts)


def reshaped(value: Expression, *sizes: Part) -> Call:
    """Returns an array in another shape; -1 stands for whatever size remains."""
    return Call(Attribute(value, "reshape"), tuple(map(constant, sizes)))


def live(body: list[Statement]) -> tuple[Statement, ...]:
    """Returns the statements of a function without assignments to variables that nothing reads."""
    kept: list[Statement] = []
    read_later: set[str] = set()
    for statement in reversed(body):
        if isinstance(statement, Assign):
            if read_later.isdisjoint(statement.names):
                continue
            read_later -= set(statement.names)
        read_later |= {node.identifier for node in walk(statement) if isinstance(node, Name)}
        kept.append(statement)
    return tuple(reversed(kept))
