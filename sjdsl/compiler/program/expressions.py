"""Expressions and statements of an array program: frozen nodes, which `lower` builds and only `emit` turns into text.

Two nodes are equal if they compute the same; the name that a literal is printed under does not matter to that.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, is_dataclass
from functools import cache
from types import EllipsisType
from typing import Any, TypeAlias
from typing import Literal as OneOf

from sjdsl.compiler.diagnostics.source import Span

DType: TypeAlias = OneOf["f32", "i32", "u32", "u8", "bool"]


@dataclass(frozen=True)
class Name:
    """A variable of a function, a constant of the module, a kernel, or what is imported."""

    identifier: str


@dataclass(frozen=True, eq=False)
class Literal:
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


@dataclass(frozen=True)
class Attribute:
    """`value.name`."""

    value: Expression
    name: str


@dataclass(frozen=True)
class Call:
    """`function(arguments, keyword=argument, …)`."""

    function: Expression
    arguments: tuple[Expression, ...] = ()
    keywords: tuple[tuple[str, Expression], ...] = ()


@dataclass(frozen=True)
class Slice:
    """`start:stop` in an index."""

    start: Expression | None = None
    stop: Expression | None = None


@dataclass(frozen=True)
class Index:
    """`value[keys]`."""

    value: Expression
    keys: tuple[Expression | Slice, ...]


@dataclass(frozen=True)
class Unary:
    """`~operand` or `-operand`."""

    op: OneOf["~", "-"]
    operand: Expression


@dataclass(frozen=True)
class Binary:
    """An operation or comparison of two arrays, entry by entry."""

    op: str
    left: Expression
    right: Expression


@dataclass(frozen=True)
class Where:
    """`then` where the condition holds, else `otherwise`."""

    condition: Expression
    then: Expression
    otherwise: Expression


@dataclass(frozen=True)
class Cast:
    """An array in another dtype. `source`: what it was, if that is known."""

    value: Expression
    dtype: DType
    source: DType | None = None


@dataclass(frozen=True)
class Reduce:
    """`any`, `all`, `sum` or `max` over some axes, all of them if there are none named. `dtype`: of a sum."""

    fn: OneOf["any", "all", "sum", "max"]
    value: Expression
    axes: tuple[int, ...] | None = None
    dtype: DType | None = None


@dataclass(frozen=True)
class Broadcast:
    """An array spread out to a shape."""

    value: Expression
    shape: tuple[Expression, ...]


@dataclass(frozen=True)
class Arange:
    """0, 1, … along an axis."""

    size: Expression
    dtype: DType | None = None


@dataclass(frozen=True)
class Update:
    """An array with new values at some keys, or with values added to them; `drop`: keys past the end change nothing."""

    target: Expression
    keys: tuple[Expression | Slice, ...]
    fn: OneOf["set", "add"]
    value: Expression
    drop: bool = False


@dataclass(frozen=True)
class Sequence:
    """A tuple, or a list."""

    items: tuple[Expression, ...]
    is_list: bool = False


@dataclass(frozen=True)
class Mapping:
    """A dictionary with texts for keys."""

    entries: tuple[tuple[str, Expression], ...]


@dataclass(frozen=True)
class Lambda:
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


@dataclass(frozen=True)
class Assign:
    """Gives names to a value; several take it apart. `origin`: the line of the `.sj` file it comes from."""

    names: tuple[str, ...]
    value: Expression
    origin: Span | None = field(default=None, compare=False)


@dataclass(frozen=True)
class Return:
    """Ends a function; several values are a tuple."""

    values: tuple[Expression, ...]
    origin: Span | None = field(default=None, compare=False)


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
