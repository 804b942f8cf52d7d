"""The base classes of IR nodes: frozen, equal by content; and types."""

from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field
from pydantic_core import CoreSchema, core_schema

from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.diagnostics.tree import TreeNode
from sjdsl.compiler.ir.entity_types import IndexSet

Unit = Literal["count", "steps", "cells", "reward", "probability", "fraction", "number"]


class InstanceCheck:
    """Has pydantic check that a value is an instance, and nothing about its own fields.

    Those were checked when it was made.

    (Pydantic's `InstanceOf` adds the whole schema of the class, for reading JSON, to that of every
    model that holds one.)
    """

    def __get_pydantic_core_schema__(self, kind: type, handler: Any) -> CoreSchema:
        del handler
        return core_schema.is_instance_schema(kind)


INSTANCE = InstanceCheck()


class Model(BaseModel):
    """Something frozen, equal by content."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    def changed(self, **changes: Any) -> Self:
        """Returns this with some fields changed; their new values aren't checked."""
        return self.model_copy(update=changes)


class Node(Model, TreeNode["Node"]):
    """A frozen part of the IR. `origin` is where the author wrote it."""

    # Pydantic builds what checks a node's fields when the first one is made: no game has nodes of
    # all classes.
    model_config = ConfigDict(defer_build=True)
    origin: Annotated[Span, INSTANCE] | None = Field(default=None, repr=False)

    @property
    def span(self) -> Span:
        """Where the author wrote it; not for nodes that the compiler has made."""
        assert self.origin is not None, self
        return self.origin


class Expression(Node):
    """Something with a value."""


class Statement(Node):
    """Something a phase does."""


class RestrictionNode(Node):
    """Where the members of a domain are looked for."""


class TurnNode(Node):
    """One place of the schedule."""


class CourseNode(Node):
    """Which way movers go."""


class PolicyRuleNode(Node):
    """One rule of a scripted policy."""


class Type(Model):
    """What values an expression has.

    kind: `word` (one of `words`), `int` and `real` (`unit`, `low` .. `high`), `condition`, `agent`
    (one or nobody), `agents` (a set), `cell` (one of `kinds`, or nowhere), `mix` (shares over
    `words`), `member` (a variable of a domain: an agent or a cell).
    indexed_by: the index sets of a row or table, outermost first; empty for a single value.
    """

    kind: Literal["word", "int", "real", "condition", "agent", "agents", "cell", "mix", "member"]
    words: tuple[str, ...] = ()
    kinds: tuple[str, ...] = ()
    unit: Unit = "number"
    low: float = float("-inf")
    high: float = float("inf")
    indexed_by: tuple[Annotated[IndexSet, INSTANCE], ...] = ()

    def is_single(self, *kinds: str) -> bool:
        """Returns whether values are single ones, and of one of these kinds."""
        return self.kind in kinds and not self.indexed_by


CONDITION = Type(kind="condition")
AGENT = Type(kind="agent")
AGENTS = Type(kind="agents")
CELL = Type(kind="cell")
