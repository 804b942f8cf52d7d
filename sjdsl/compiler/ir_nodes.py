"""What all parts of the IR share: frozen nodes that compare by content, and types."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field
from pydantic_core import CoreSchema, core_schema

from sjdsl.compiler.source import Span

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
    from sjdsl.compiler import ir, ir_expressions, ir_sentences

    Expr: TypeAlias = (
        ir_expressions.Number
        | ir_expressions.Word
        | ir_expressions.Truth
        | ir_expressions.Nobody
        | ir_expressions.ParamRef
        | ir_expressions.Member
        | ir_expressions.Local
        | ir_expressions.FieldRead
        | ir_expressions.Attribute
        | ir_expressions.At
        | ir_expressions.Step
        | ir_expressions.Arithmetic
        | ir_expressions.Compare
        | ir_expressions.Same
        | ir_expressions.InRange
        | ir_expressions.InWords
        | ir_expressions.InSet
        | ir_expressions.IsEmpty
        | ir_expressions.Chose
        | ir_expressions.Unoccupied
        | ir_expressions.StandsOn
        | ir_expressions.Not
        | ir_expressions.Logic
        | ir_expressions.Count
        | ir_expressions.Sum
        | ir_expressions.SumRow
        | ir_expressions.Case
        | ir_expressions.Lowest
        | ir_expressions.Mix
        | ir_expressions.Ramp
        | ir_expressions.Named
        | ir_expressions.Narrowed
        | ir_expressions.EventTotal
        | ir_expressions.MatrixClass
    )
    Stmt: TypeAlias = (
        ir_sentences.Let
        | ir_sentences.Draw
        | ir_sentences.Each
        | ir_sentences.Pick
        | ir_sentences.First
        | ir_sentences.Match
        | ir_sentences.When
        | ir_sentences.Chance
        | ir_sentences.Set
        | ir_sentences.Add
        | ir_sentences.Give
        | ir_sentences.Tally
        | ir_sentences.Send
        | ir_sentences.Remove
        | ir_sentences.Move
        | ir_sentences.Mark
        | ir_sentences.End
    )
    Place: TypeAlias = ir_sentences.Near | ir_sentences.InAgents | ir_sentences.Among
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
