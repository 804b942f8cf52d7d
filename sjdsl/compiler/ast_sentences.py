"""The tree as written, second half: domains and sentences."""

from __future__ import annotations

from dataclasses import dataclass

from sjdsl.compiler.ast_expressions import Expr, Name, Path, Table, Words
from sjdsl.compiler.source import Span


@dataclass(frozen=True)
class ShapeRef:
    """`beam` or `disc(2)`; arguments None for a named shape."""

    span: Span
    name: Name
    arguments: tuple[Expr, ...] | None


@dataclass(frozen=True)
class Near:
    """`in beam of cleaner`"""

    span: Span
    shape: ShapeRef
    anchor: Name


@dataclass(frozen=True)
class Members:
    """`in { row, column }`"""

    span: Span
    names: tuple[Name, ...]


@dataclass(frozen=True)
class On:
    span: Span
    kind: Name
    bind: Name | None


@dataclass(frozen=True)
class Domain:
    """`KIND as x on KIND as y in PLACE where c`"""

    span: Span
    kind: Name
    bind: Name | None
    on: On | None
    place: Near | Path | Members | None
    where: Expr | None


# ---- sentences


@dataclass(frozen=True)
class Block:
    span: Span
    statements: tuple[Stmt, ...]


@dataclass(frozen=True)
class Let:
    span: Span
    name: Name
    value: Expr


@dataclass(frozen=True)
class Draw:
    """`from a .. b` has high; `from { w, w }` has Words; `from { w: p }` has Table."""

    span: Span
    name: Name
    source: Expr | Words | Table
    high: Expr | None


@dataclass(frozen=True)
class Each:
    span: Span
    domain: Domain
    block: Block


@dataclass(frozen=True)
class Pick:
    span: Span
    number: Expr
    domain: Domain
    block: Block
    otherwise: Otherwise | None


@dataclass(frozen=True)
class First:
    span: Span
    domain: Domain
    block: Block
    otherwise: Otherwise | None


@dataclass(frozen=True)
class Match:
    span: Span
    left: Domain
    first: bool
    right: Domain
    block: Block


@dataclass(frozen=True)
class When:
    span: Span
    condition: Expr
    block: Block
    otherwise: Otherwise | None


@dataclass(frozen=True)
class Chance:
    span: Span
    probability: Expr
    block: Block
    otherwise: Otherwise | None


Otherwise = Block | When | Chance


@dataclass(frozen=True)
class Set:
    span: Span
    target: Path
    value: Expr


@dataclass(frozen=True)
class Add:
    span: Span
    value: Expr
    target: Path


@dataclass(frozen=True)
class All:
    """`all`, or `all but x`"""

    span: Span
    but: Name | None


@dataclass(frozen=True)
class Give:
    span: Span
    value: Expr
    receiver: Path | All


@dataclass(frozen=True)
class Tally:
    span: Span
    event: Path
    by: Expr | None
    receiver: Path | None


@dataclass(frozen=True)
class Send:
    """stay: the name after `otherwise` (must be `stay`)."""

    span: Span
    who: Path
    domain: Domain
    after: Expr | None
    facing: Name | None
    stay: Name | None


@dataclass(frozen=True)
class Remove:
    span: Span
    who: Path


@dataclass(frozen=True)
class Move:
    span: Span
    domain: Domain


@dataclass(frozen=True)
class Mark:
    span: Span
    shape: ShapeRef
    anchor: Name


@dataclass(frozen=True)
class End:
    span: Span


Stmt = Let | Draw | Each | Pick | First | Match | When | Chance | Set | Add | Give | Tally | Send | Remove | Move | Mark | End


__all__ = [
    "Add",
    "All",
    "Block",
    "Chance",
    "Domain",
    "Draw",
    "Each",
    "End",
    "First",
    "Give",
    "Let",
    "Mark",
    "Match",
    "Members",
    "Move",
    "Near",
    "On",
    "Otherwise",
    "Pick",
    "Remove",
    "Send",
    "Set",
    "ShapeRef",
    "Stmt",
    "Tally",
    "When",
]
