"""The abstract syntax tree.

Names, types, expressions, and the domains that quantifiers range over.
"""

from __future__ import annotations

from sjdsl.compiler.ast.node import Node


class Name(Node):
    text: str


class Named(Node):
    """A part that begins with its name, or has one alone."""

    name: Name


class String(Node):
    text: str


class Words(Node):
    """`{ none, ripe }`"""

    names: tuple[Name, ...]


class Range(Node):
    """`0 .. cap capped`"""

    low: Expr
    high: Expr
    capped: bool


class Reals(Node):
    """`number in 0 .. 1.5 capped`"""

    unit: Name
    low: Expr
    high: Expr
    capped: bool


class Numbers(Node):
    """`0 .. 4` after `by`"""

    low: Expr
    high: Expr


class NamedType(Node):
    """`agent`, `set of agent`, `reward`, `fraction`"""

    set_of: bool
    name: Name


class CellType(Node):
    """`cell of gate`; `sort`: the first word."""

    sort: Name
    of: Name


Type = Words | Range | Reals | NamedType | CellType
By = (
    Words | Numbers | Name
)  # what the entries of a row are told apart by; the name of a sort is `agent`


# ---- expressions


class Int(Node):
    value: int


class Decimal(Node):
    value: float


class Nobody(Node):
    """`nobody`"""


class Path(Named):
    """`a.bag[raw]`: a name, then members and indices in order."""

    steps: tuple[Member | Index, ...]


class Member(Named):
    """`.bag`"""


class Index(Node):
    key: Expr


class Call(Named):
    """`ramp(x, zero_at, one_at)`, `ready(row)`, `disc(2)`"""

    arguments: tuple[Expr, ...]


class Count(Node):
    domain: Domain


class Quantified(Node):
    """`any(D)` or `all(D)`, by its word."""

    word: str
    domain: Domain


class Total(Node):
    """`sum(row)` or `sum(e over D)`"""

    value: Expr
    domain: Domain | None


class Extreme(Named):
    """`min(e over D otherwise v)`; the name need not be one of a function."""

    value: Expr
    domain: Domain
    if_none: Expr | None


class Case(Node):
    subject: Expr
    arms: tuple[Arm, ...]


class Arm(Node):
    """`3..: e` has low 3, high None, open True; `otherwise: e` has word None and low None."""

    low: int | None
    high: int | None
    open: bool
    word: Name | None
    value: Expr


class Unary(Node):
    """op: `+`, `-`, `not`"""

    op: str
    operand: Expr


class Binary(Node):
    """op: `+ - * / % ^`, `<= >= == != < >`, `and`, `or`, `is`, `is not`"""

    op: str
    left: Expr
    right: Expr


class Chosen(Named):
    """An action that is spoken of.

    `zap`, `vote(friend)`; arguments None for one without brackets.
    """

    arguments: tuple[Expr, ...] | None


class Chose(Node):
    """`zapper chose zap`"""

    agent: Expr
    action: Chosen


class Standing(Node):
    """`nobody on soil`, `agent on grass`"""

    who: Expr
    kind: Name


class Within(Node):
    """`x in set`; `x in { a, b }` has words; `x in low .. high` has high."""

    value: Expr
    container: Expr | Words
    high: Expr | None


Expr = (
    Int
    | Decimal
    | Nobody
    | Path
    | Call
    | Count
    | Quantified
    | Total
    | Extreme
    | Case
    | Unary
    | Binary
    | Chose
    | Standing
    | Within
)


class Table(Node):
    """`{ red: 0.25, green: 0.4 }`; values may be tables."""

    entries: tuple[Entry, ...]


class Entry(Node):
    """The key as written: a word, `3`, `1 .. 3`, `3 ..` or `otherwise`."""

    key: Name
    value: Expr | Table


# ---- domains


class ShapeRef(Named):
    """`beam` or `disc(2)`; arguments None for a named shape."""

    arguments: tuple[Expr, ...] | None


class Near(Node):
    """`in beam of cleaner`"""

    shape: ShapeRef
    anchor: Name


class Members(Node):
    """`in { row, column }`"""

    names: tuple[Name, ...]


class On(Node):
    kind: Name
    bind: Name | None


class Domain(Node):
    """`KIND as x on KIND as y in PLACE where c`"""

    kind: Name
    bind: Name | None
    on: On | None
    restriction: Near | Path | Members | None
    where: Expr | None
