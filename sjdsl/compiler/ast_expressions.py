"""The tree as written, first half: names, types and expressions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from sjdsl.compiler.source import Span

if TYPE_CHECKING:
    from sjdsl.compiler.ast_sentences import Domain


@dataclass(frozen=True)
class Name:
    span: Span
    text: str


@dataclass(frozen=True)
class String:
    span: Span
    text: str


@dataclass(frozen=True)
class Words:
    """`{ none, ripe }`"""

    span: Span
    names: tuple[Name, ...]


@dataclass(frozen=True)
class Range:
    """`0 .. cap capped`"""

    span: Span
    low: Expr
    high: Expr
    capped: bool


@dataclass(frozen=True)
class NamedType:
    """`agent`, `set of agent`, `reward`"""

    span: Span
    set_of: bool
    name: Name


Type = Words | Range | NamedType


# ---- expressions


@dataclass(frozen=True)
class Int:
    span: Span
    value: int


@dataclass(frozen=True)
class Decimal:
    span: Span
    value: float


@dataclass(frozen=True)
class Nobody:
    span: Span


@dataclass(frozen=True)
class Path:
    """`a.bag[raw]`: a name, then members and indices in order."""

    span: Span
    name: Name
    steps: tuple[Member | Index, ...]


@dataclass(frozen=True)
class Member:
    span: Span
    name: Name


@dataclass(frozen=True)
class Index:
    span: Span
    key: Expr


@dataclass(frozen=True)
class Call:
    """`ramp(x, zero_at, one_at)`, `ready(row)`, `disc(2)`"""

    span: Span
    name: Name
    arguments: tuple[Expr, ...]


@dataclass(frozen=True)
class Count:
    span: Span
    domain: Domain


@dataclass(frozen=True)
class Total:
    """`sum(row)` or `sum(e over D)`"""

    span: Span
    value: Expr
    domain: Domain | None


@dataclass(frozen=True)
class Case:
    span: Span
    subject: Expr
    arms: tuple[Arm, ...]


@dataclass(frozen=True)
class Arm:
    """`3..: e` has low 3, high None, open True; `otherwise: e` has word None and low None."""

    span: Span
    low: int | None
    high: int | None
    open: bool
    word: Name | None
    value: Expr


@dataclass(frozen=True)
class Unary:
    """op: `+`, `-`, `not`"""

    span: Span
    op: str
    operand: Expr


@dataclass(frozen=True)
class Binary:
    """op: `+ - * / %`, `<= >= == != < >`, `and`, `or`, `is`, `is not`"""

    span: Span
    op: str
    left: Expr
    right: Expr


@dataclass(frozen=True)
class Chose:
    """`zapper chose zap`"""

    span: Span
    agent: Expr
    action: Name


@dataclass(frozen=True)
class Standing:
    """`nobody on soil`, `agent on grass`"""

    span: Span
    who: Expr
    kind: Name


@dataclass(frozen=True)
class Within:
    """`x in set`; `x in { a, b }` has words; `x in low .. high` has high."""

    span: Span
    value: Expr
    container: Expr | Words
    high: Expr | None


Expr = Int | Decimal | Nobody | Path | Call | Count | Total | Case | Unary | Binary | Chose | Standing | Within


@dataclass(frozen=True)
class Table:
    """`{ red: 0.25, green: 0.4 }`; values may be tables."""

    span: Span
    entries: tuple[Entry, ...]


@dataclass(frozen=True)
class Entry:
    span: Span
    key: Name
    value: Expr | Table


__all__ = [
    "Arm",
    "Binary",
    "Call",
    "Case",
    "Chose",
    "Count",
    "Decimal",
    "Entry",
    "Expr",
    "Index",
    "Int",
    "Member",
    "Name",
    "NamedType",
    "Nobody",
    "Path",
    "Range",
    "Standing",
    "String",
    "Table",
    "Total",
    "Type",
    "Unary",
    "Within",
    "Words",
]
