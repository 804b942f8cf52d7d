"""Expressions and statements of an array program: frozen nodes, which `lower` builds and only `emit` turns into text.

Two expressions are equal if they compute the same; the name that a literal is printed under does not matter to that.
"""

from __future__ import annotations

from types import EllipsisType
from typing import Literal as OneOf
from typing import TypeAlias

from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.diagnostics.tree import TreeNode, walk

DType: TypeAlias = OneOf["f32", "i32", "u32", "u8", "bool"]


class Node(Record, TreeNode["Node"]):
    """A part of a program."""


class Name(Node):
    """A variable of a function, a constant of the module, a kernel, or what is imported."""

    identifier: str


class Literal(Node):
    """A number, truth, text, None (in an index: a new axis) or `...`. `name`: the module's constant that has this value."""

    value: bool | int | float | str | EllipsisType | None
    name: str = ""

    @property
    def size(self) -> int:
        """The whole number that a literal is."""
        assert isinstance(self.value, int)
        return self.value

    def __eq__(self, other: object) -> bool:  # 1, 1.0 and True differ
        return (
            isinstance(other, Literal)
            and type(self.value) is type(other.value)
            and self.value == other.value
        )

    def __hash__(self) -> int:
        return hash((type(self.value), self.value))


class Attribute(Node):
    """`value.name`."""

    value: Expression
    name: str


class Call(Node):
    """`function(arguments, keyword=argument, …)`."""

    function: Expression
    arguments: tuple[Expression, ...] = ()
    keywords: tuple[tuple[str, Expression], ...] = ()


class Slice(Node):
    """`start:stop` in an index."""

    start: Expression | None = None
    stop: Expression | None = None


class Index(Node):
    """`value[keys]`."""

    value: Expression
    keys: tuple[Expression | Slice, ...]


class Unary(Node):
    """`~operand` or `-operand`."""

    op: str
    operand: Expression


class Binary(Node):
    """An operation or comparison of two arrays, entry by entry."""

    op: str
    left: Expression
    right: Expression


class Where(Node):
    """`then` where the condition holds, else `otherwise`."""

    condition: Expression
    then: Expression
    otherwise: Expression


class Cast(Node):
    """An array in another dtype. `source`: what it was, if that is known."""

    value: Expression
    dtype: DType
    source: DType | None = None


class Broadcast(Node):
    """An array spread out to a shape."""

    value: Expression
    shape: tuple[Expression, ...]


class Arange(Node):
    """0, 1, … along an axis."""

    size: Expression
    dtype: DType | None = None


class Sequence(Node):
    """A tuple, or a list."""

    items: tuple[Expression, ...]
    is_list: bool = False


class Mapping(Node):
    """A dictionary with texts for keys."""

    entries: tuple[tuple[str, Expression], ...]


class Lambda(Node):
    """A function of its parameters."""

    parameters: tuple[str, ...]
    body: Expression


OfArrays: TypeAlias = Unary | Binary | Where | Cast | Broadcast | Arange
Expression: TypeAlias = (
    Name | Literal | Attribute | Call | Index | OfArrays | Sequence | Mapping | Lambda
)


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
