"""Expressions and statements of an array program: frozen nodes, which `lower` builds and only `emit` turns into text.

Two expressions are equal if they compute the same; the name that a literal is printed under does not matter to that.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from functools import cache
from types import EllipsisType
from typing import Any, TypeAlias
from typing import Literal as OneOf

from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.source import Span

DType: TypeAlias = OneOf["f32", "i32", "u32", "u8", "bool"]


class Name(Record):
    """A variable of a function, a constant of the module, a kernel, or what is imported."""

    identifier: str


class Literal(Record):
    """A number, truth, text, None (in an index: a new axis) or `...`. `name`: the module's constant that has this value."""

    value: bool | int | float | str | EllipsisType | None
    name: str = ""

    @property
    def size(self) -> int:
        """The whole number that a literal is."""
        assert isinstance(self.value, int)
        return self.value

    def __eq__(self, other: object) -> bool:  # 1, 1.0 and True differ
        return isinstance(other, Literal) and type(self.value) is type(other.value) and self.value == other.value

    def __hash__(self) -> int:
        return hash((type(self.value), self.value))


class Attribute(Record):
    """`value.name`."""

    value: Expression
    name: str


class Call(Record):
    """`function(arguments, keyword=argument, …)`."""

    function: Expression
    arguments: tuple[Expression, ...] = ()
    keywords: tuple[tuple[str, Expression], ...] = ()


class Slice(Record):
    """`start:stop` in an index."""

    start: Expression | None = None
    stop: Expression | None = None


class Index(Record):
    """`value[keys]`."""

    value: Expression
    keys: tuple[Expression | Slice, ...]


class Unary(Record):
    """`~operand` or `-operand`."""

    op: str
    operand: Expression


class Binary(Record):
    """An operation or comparison of two arrays, entry by entry."""

    op: str
    left: Expression
    right: Expression


class Where(Record):
    """`then` where the condition holds, else `otherwise`."""

    condition: Expression
    then: Expression
    otherwise: Expression


class Cast(Record):
    """An array in another dtype. `source`: what it was, if that is known."""

    value: Expression
    dtype: DType
    source: DType | None = None


class Reduce(Record):
    """`any`, `all`, `sum`, `min` or `max` over some axes, all of them if there are none named. `dtype`: of a sum."""

    fn: OneOf["any", "all", "sum", "min", "max"]
    value: Expression
    axes: tuple[int, ...] | None = None
    dtype: DType | None = None


class Broadcast(Record):
    """An array spread out to a shape."""

    value: Expression
    shape: tuple[Expression, ...]


class Arange(Record):
    """0, 1, … along an axis."""

    size: Expression
    dtype: DType | None = None


class Update(Record):
    """An array with new values at some keys, or with values added to them; `drop`: keys past the end change nothing."""

    target: Expression
    keys: tuple[Expression | Slice, ...]
    fn: OneOf["set", "add"]
    value: Expression
    drop: bool = False


class Sequence(Record):
    """A tuple, or a list."""

    items: tuple[Expression, ...]
    is_list: bool = False


class Mapping(Record):
    """A dictionary with texts for keys."""

    entries: tuple[tuple[str, Expression], ...]


class Lambda(Record):
    """A function of its parameters."""

    parameters: tuple[str, ...]
    body: Expression


Expression: TypeAlias = (
    Name
    | Literal
    | Attribute
    | Call
    | Index
    | Unary
    | Binary
    | Where
    | Cast
    | Reduce
    | Broadcast
    | Arange
    | Update
    | Sequence
    | Mapping
    | Lambda
)


class Assign(Record):
    """Gives names to a value; several take it apart. `origin`: the line of the `.sj` file it comes from."""

    names: tuple[str, ...]
    value: Expression
    origin: Span | None = None


class Return(Record):
    """Ends a function; several values are a tuple."""

    values: tuple[Expression, ...]
    origin: Span | None = None


Statement: TypeAlias = Assign | Return

ALL = Slice()
NEW_AXIS = Literal(None)
REST = Literal(...)


def call(function: str, *arguments: Expression, **keywords: Expression) -> Call:
    """Returns a call of a kernel, or of a method or function with a path such as `jnp.concatenate`."""
    return Call(path(function), arguments, tuple(keywords.items()))


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


def as_array(value: Expression, dtype: DType | None = None) -> Call:
    """Returns numbers as an array."""
    return Call(path("jnp.asarray"), (value,) if dtype is None else (value, DTYPES[dtype]))


def scalar(value: Expression, dtype: DType) -> Call:
    """Returns a number with its dtype, such as `jnp.int32(1)`."""
    return Call(DTYPES[dtype], (value,))


def constant(value: object) -> Expression:
    """Returns numbers, texts, tuples, lists and dictionaries as they are written."""
    if isinstance(value, tuple | list):
        return Sequence(tuple(map(constant, value)), isinstance(value, list))
    if isinstance(value, dict):
        return Mapping(tuple((key, constant(entry)) for key, entry in value.items()))
    assert value is None or isinstance(value, bool | int | float | str)
    return Literal(value)


def shape_of(sizes: tuple[Expression, ...]) -> Expression:
    """Returns a shape as an argument: a number for one axis, else a tuple."""
    return sizes[0] if len(sizes) == 1 else Sequence(sizes)


def walk(node: object) -> Iterator[object]:
    """Yields a node and all nodes below it, outermost first."""
    waiting: list[Any] = [node]
    while waiting:
        following = waiting.pop()
        if isinstance(following, tuple):
            waiting += reversed(following)
        elif (parts := _parts(following.__class__)) is not None:
            yield following
            waiting += [getattr(following, name) for name in reversed(parts)]


@cache
def _parts(kind: type) -> tuple[str, ...] | None:
    """Returns the fields of a class of nodes that can hold nodes, None for what is no node."""
    return tuple(f.name for f in fields(kind) if f.name != "origin") if is_dataclass(kind) else None


def live(body: list[Statement]) -> tuple[Statement, ...]:
    """Returns the statements without those that give a name to what nothing reads."""
    kept: list[Statement] = []
    read: set[str] = set()
    for statement in reversed(body):
        if isinstance(statement, Assign):
            if read.isdisjoint(statement.names):
                continue
            read -= set(statement.names)
        read |= {node.identifier for node in walk(statement) if isinstance(node, Name)}
        kept.append(statement)
    return tuple(reversed(kept))
