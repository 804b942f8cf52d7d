"""The abstract syntax tree: names, types, expressions, and the domains that quantifiers range over."""

from __future__ import annotations

from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.diagnostics.source import Span


class Name(Node):
    span: Span
    text: str


class String(Node):
    span: Span
    text: str


class Words(Node):
    """`{ none, ripe }`"""

    span: Span
    names: tuple[Name, ...]


class Range(Node):
    """`0 .. cap capped`"""

    span: Span
    low: Expr
    high: Expr
    capped: bool


class Numbers(Node):
    """`0 .. 4` after `by`"""

    span: Span
    low: Expr
    high: Expr


class NamedType(Node):
    """`agent`, `set of agent`, `reward`"""

    span: Span
    set_of: bool
    name: Name


class CellType(Node):
    """`cell of gate`; `sort`: the first word."""

    span: Span
    sort: Name
    of: Name


Type = Words | Range | NamedType | CellType
By = Words | Numbers | Name  # what the entries of a row are told apart by; the name of a sort is `agent`


# ---- expressions


class Int(Node):
    span: Span
    value: int


class Decimal(Node):
    span: Span
    value: float


class Nobody(Node):
    span: Span


class Path(Node):
    """`a.bag[raw]`: a name, then members and indices in order."""

    span: Span
    name: Name
    steps: tuple[Member | Index, ...]


class Member(Node):
    span: Span
    name: Name


class Index(Node):
    span: Span
    key: Expr


class Call(Node):
    """`ramp(x, zero_at, one_at)`, `ready(row)`, `disc(2)`"""

    span: Span
    name: Name
    arguments: tuple[Expr, ...]


class Count(Node):
    span: Span
    domain: Domain


class Quantified(Node):
    """`any(D)` or `all(D)`, by its word."""

    span: Span
    word: str
    domain: Domain


class Total(Node):
    """`sum(row)` or `sum(e over D)`"""

    span: Span
    value: Expr
    domain: Domain | None


class Extreme(Node):
    """`min(e over D otherwise v)`; the name need not be one of a function."""

    span: Span
    name: Name
    value: Expr
    domain: Domain
    if_none: Expr | None


class Case(Node):
    span: Span
    subject: Expr
    arms: tuple[Arm, ...]


class Arm(Node):
    """`3..: e` has low 3, high None, open True; `otherwise: e` has word None and low None."""

    span: Span
    low: int | None
    high: int | None
    open: bool
    word: Name | None
    value: Expr


class Unary(Node):
    """op: `+`, `-`, `not`"""

    span: Span
    op: str
    operand: Expr


class Binary(Node):
    """op: `+ - * / %`, `<= >= == != < >`, `and`, `or`, `is`, `is not`"""

    span: Span
    op: str
    left: Expr
    right: Expr


class Chosen(Node):
    """An action that is spoken of: `zap`, `vote(friend)`; arguments None for one without brackets."""

    span: Span
    name: Name
    arguments: tuple[Expr, ...] | None


class Chose(Node):
    """`zapper chose zap`"""

    span: Span
    agent: Expr
    action: Chosen


class Standing(Node):
    """`nobody on soil`, `agent on grass`"""

    span: Span
    who: Expr
    kind: Name


class Within(Node):
    """`x in set`; `x in { a, b }` has words; `x in low .. high` has high."""

    span: Span
    value: Expr
    container: Expr | Words
    high: Expr | None


Expr = Int | Decimal | Nobody | Path | Call | Count | Quantified | Total | Extreme | Case | Unary | Binary | Chose | Standing | Within


class Table(Node):
    """`{ red: 0.25, green: 0.4 }`; values may be tables."""

    span: Span
    entries: tuple[Entry, ...]


class Entry(Node):
    """The key as written: a word, `3`, `1 .. 3`, `3 ..` or `otherwise`."""

    span: Span
    key: Name
    value: Expr | Table


# ---- domains


class ShapeRef(Node):
    """`beam` or `disc(2)`; arguments None for a named shape."""

    span: Span
    name: Name
    arguments: tuple[Expr, ...] | None


class Near(Node):
    """`in beam of cleaner`"""

    span: Span
    shape: ShapeRef
    anchor: Name


class Members(Node):
    """`in { row, column }`"""

    span: Span
    names: tuple[Name, ...]


class On(Node):
    span: Span
    kind: Name
    bind: Name | None


class Domain(Node):
    """`KIND as x on KIND as y in PLACE where c`"""

    span: Span
    kind: Name
    bind: Name | None
    on: On | None
    restriction: Near | Path | Members | None
    where: Expr | None
