"""The abstract syntax tree: statements of a phase."""

from __future__ import annotations

from typing import Literal

from sjdsl.compiler.ast.expressions import (
    By,
    Domain,
    Expr,
    Name,
    Named,
    Path,
    ShapeRef,
    Table,
    Words,
)
from sjdsl.compiler.ast.node import Node


class Block(Node):
    statements: tuple[Stmt, ...]


class Let(Named):
    value: Expr


class Draw(Named):
    """`from a .. b` has high; `from { w, w }` has Words; `from { w: p }` has Table.

    by: of a row, of which each entry is drawn; different: no two of them are equal.
    """

    by: By | None
    different: bool
    source: Expr | Words | Table
    high: Expr | None


class Each(Node):
    domain: Domain
    block: Block


class Pick(Node):
    number: Expr
    domain: Domain
    block: Block
    otherwise: Otherwise | None


class First(Node):
    domain: Domain
    block: Block


class Match(Node):
    left: Domain
    first: bool
    right: Domain
    block: Block


class When(Node):
    condition: Expr
    block: Block
    otherwise: Otherwise | None


class Chance(Node):
    probability: Expr
    block: Block
    otherwise: Otherwise | None


Otherwise = Block | When | Chance


class Set(Node):
    """lot: the name after `by` (must be `lot`)."""

    target: Path
    value: Expr
    lot: Name | None


class Add(Node):
    value: Expr
    target: Path


class All(Node):
    """`all`, or `all but x`"""

    but: Name | None


class Give(Node):
    value: Expr
    receiver: Path | All


class Tally(Node):
    event: Path
    by: Expr | None
    receiver: Path | None


class Send(Node):
    """To a domain of cells, or to the cell of a path.

    stay: the name after `otherwise` (must be `stay`).
    """

    who: Path
    domain: Domain | Path
    after: Expr | None
    facing: Path | None
    stay: Name | None


class Direction(Node):
    """`along` a path that is a heading, `away` from one, or `toward` one.

    A path that is a heading can be `ahead`, `back`, `left` or `right`.
    """

    how: Literal["along", "away", "toward"]
    path: Path


class Shift(Node):
    """`send x by n DIRECTION`; stay: the name after `otherwise` (must be `stay`)."""

    who: Path
    steps: Expr
    direction: Direction
    facing: Path | None
    stay: Name | None


class Remove(Node):
    who: Path


class Toward(Node):
    """`toward D avoiding E`, or `away from D avoiding E`"""

    domain: Domain
    avoided: Domain | None


class AwayFrom(Node):
    domain: Domain
    avoided: Domain | None


class AtRandom(Node):
    avoided: Domain | None


class Ahead(Node):
    """`ahead`"""


class Along(Node):
    heading: Expr


Course = Toward | AwayFrom | AtRandom | Ahead | Along


class Move(Node):
    """Agents move as they chose; movers take a `course`."""

    domain: Domain
    course: Course | None


class Mark(Node):
    shape: ShapeRef
    anchor: Name


class End(Node):
    """`end`"""


Stmt = (
    Let
    | Draw
    | Each
    | Pick
    | First
    | Match
    | When
    | Chance
    | Set
    | Add
    | Give
    | Tally
    | Send
    | Shift
    | Remove
    | Move
    | Mark
    | End
)
