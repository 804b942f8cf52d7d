"""The abstract syntax tree: statements of a phase."""

from __future__ import annotations

from typing import Literal

from sjdsl.compiler.ast.expressions import Domain, Expr, Name, Path, ShapeRef, Table, Words
from sjdsl.compiler.ast.node import Node
from sjdsl.compiler.diagnostics.source import Span


class Block(Node):
    span: Span
    statements: tuple[Stmt, ...]


class Let(Node):
    span: Span
    name: Name
    value: Expr


class Draw(Node):
    """`from a .. b` has high; `from { w, w }` has Words; `from { w: p }` has Table."""

    span: Span
    name: Name
    source: Expr | Words | Table
    high: Expr | None


class Each(Node):
    span: Span
    domain: Domain
    block: Block


class Pick(Node):
    span: Span
    number: Expr
    domain: Domain
    block: Block
    otherwise: Otherwise | None


class First(Node):
    span: Span
    domain: Domain
    block: Block
    otherwise: Otherwise | None


class Match(Node):
    span: Span
    left: Domain
    first: bool
    right: Domain
    block: Block


class When(Node):
    span: Span
    condition: Expr
    block: Block
    otherwise: Otherwise | None


class Chance(Node):
    span: Span
    probability: Expr
    block: Block
    otherwise: Otherwise | None


Otherwise = Block | When | Chance


class Set(Node):
    """lot: the name after `by` (must be `lot`)."""

    span: Span
    target: Path
    value: Expr
    lot: Name | None


class Add(Node):
    span: Span
    value: Expr
    target: Path


class All(Node):
    """`all`, or `all but x`"""

    span: Span
    but: Name | None


class Give(Node):
    span: Span
    value: Expr
    receiver: Path | All


class Tally(Node):
    span: Span
    event: Path
    by: Expr | None
    receiver: Path | None


class Send(Node):
    """To a domain of cells, or to the cell of a path; stay: the name after `otherwise` (must be `stay`)."""

    span: Span
    who: Path
    domain: Domain | Path
    after: Expr | None
    facing: Name | None
    stay: Name | None


class Direction(Node):
    """`along` a path that is a heading (or `ahead`, `back`, `left`, `right`), `away` from it, or `toward` it."""

    span: Span
    how: Literal["along", "away", "toward"]
    path: Path


class Shift(Node):
    """`send x by n DIRECTION`; stay: the name after `otherwise` (must be `stay`)."""

    span: Span
    who: Path
    steps: Expr
    direction: Direction
    facing: Name | None
    stay: Name | None


class Remove(Node):
    span: Span
    who: Path


class Toward(Node):
    """`toward D avoiding E`, or `away from D avoiding E`"""

    span: Span
    domain: Domain
    avoided: Domain | None


class AwayFrom(Node):
    span: Span
    domain: Domain
    avoided: Domain | None


class AtRandom(Node):
    span: Span
    avoided: Domain | None


class Ahead(Node):
    span: Span


class Along(Node):
    span: Span
    heading: Expr


Course = Toward | AwayFrom | AtRandom | Ahead | Along


class Move(Node):
    """Agents move as they chose; movers take a `course`."""

    span: Span
    domain: Domain
    course: Course | None


class Mark(Node):
    span: Span
    shape: ShapeRef
    anchor: Name


class End(Node):
    span: Span


Stmt = Let | Draw | Each | Pick | First | Match | When | Chance | Set | Add | Give | Tally | Send | Shift | Remove | Move | Mark | End
