"""What all parts of the IR share: frozen nodes that compare by content, and types."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field
from pydantic_core import CoreSchema, core_schema

from sjdsl.compiler.diagnostics.source import Span

Unit = Literal["count", "steps", "cells", "reward", "probability", "fraction", "number"]


class InstanceCheck:
    """Has pydantic check that a value is an instance, and nothing about its own fields: those were checked when it was made.

    (Pydantic's `InstanceOf` adds the whole schema of the class, for reading JSON, to that of every model that holds one.)
    """

    def __get_pydantic_core_schema__(self, kind: type, handler: Any) -> CoreSchema:
        del handler
        return core_schema.is_instance_schema(kind)


INSTANCE = InstanceCheck()


class Node(BaseModel):
    """A frozen part of the IR. `origin` is where the author wrote it."""

    # what checks a node's fields is built when the first one is made: no game has nodes of all classes
    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)
    origin: Annotated[Span, INSTANCE] | None = Field(default=None, repr=False)


class Expression(Node):
    """Something with a value."""


class Sentence(Node):
    """Something a phase does."""


class PlaceNode(Node):
    """Where the members of a domain are looked for."""


class TurnNode(Node):
    """One place of the schedule."""


# Pydantic checks that a child is *some* expression; the closed unions are for `match` and the type checker. (Discriminated
# unions would make every model's schema contain every other: half a second at import.)
if TYPE_CHECKING:
    from sjdsl.compiler import ir
    from sjdsl.compiler.ir import expressions, statements

    Expr: TypeAlias = (
        expressions.Number
        | expressions.Word
        | expressions.Truth
        | expressions.Nobody
        | expressions.ParamRef
        | expressions.Member
        | expressions.Local
        | expressions.FieldRead
        | expressions.Attribute
        | expressions.At
        | expressions.Step
        | expressions.Arithmetic
        | expressions.Compare
        | expressions.Same
        | expressions.InRange
        | expressions.InWords
        | expressions.InSet
        | expressions.IsEmpty
        | expressions.Chose
        | expressions.Unoccupied
        | expressions.StandsOn
        | expressions.Not
        | expressions.Logic
        | expressions.Count
        | expressions.Sum
        | expressions.SumRow
        | expressions.Case
        | expressions.Lowest
        | expressions.Mix
        | expressions.Ramp
        | expressions.Named
        | expressions.Narrowed
        | expressions.EventTotal
        | expressions.MatrixClass
    )
    Stmt: TypeAlias = (
        statements.Let
        | statements.Draw
        | statements.Each
        | statements.Pick
        | statements.First
        | statements.Match
        | statements.When
        | statements.Chance
        | statements.Set
        | statements.Add
        | statements.Give
        | statements.Tally
        | statements.Send
        | statements.Remove
        | statements.Move
        | statements.Mark
        | statements.End
    )
    Place: TypeAlias = statements.Near | statements.InAgents | statements.Among
    Turn: TypeAlias = ir.Phase | ir.Tick
else:
    Expr = Annotated[Expression, INSTANCE]
    Stmt = Annotated[Sentence, INSTANCE]
    Place = Annotated[PlaceNode, INSTANCE]
    Turn = Annotated[TurnNode, INSTANCE]


class Type(BaseModel):
    """What values an expression has.

    kind: `word` (one of `words`), `int` and `real` (`unit`, `low` .. `high`), `condition`, `agent` (one or nobody),
      `agents` (a set), `mix` (shares over `words`), `member` (a variable of a domain: an agent or a cell).
    by: word sets of the table or row levels, outermost first; empty for a single value.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")
    kind: Literal["word", "int", "real", "condition", "agent", "agents", "mix", "member"]
    words: tuple[str, ...] = ()
    unit: Unit = "number"
    low: float = float("-inf")
    high: float = float("inf")
    by: tuple[tuple[str, ...], ...] = ()


CONDITION = Type(kind="condition")
AGENT = Type(kind="agent")
AGENTS = Type(kind="agents")


__all__ = [
    "AGENT",
    "AGENTS",
    "CONDITION",
    "Expr",
    "Expression",
    "Node",
    "Place",
    "PlaceNode",
    "Sentence",
    "Stmt",
    "Turn",
    "TurnNode",
    "Type",
    "Unit",
]
