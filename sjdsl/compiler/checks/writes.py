"""Writes of a phase as the check of conflicts sees them: what is written, and all that stands around the statement."""

from functools import cached_property
from typing import Literal

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.equivalence import Form
from sjdsl.compiler.ir.free_variables import free_variables
from sjdsl.compiler.ir.implications import Fact


class Quantifier(Record):
    """One quantifier: the statement, the variables it binds, and whether it gives at most one instance for each around it."""

    statement: ir.Stmt
    binds: tuple[ir.Member, ...]
    single: bool


class Branch(Record):
    """One way through a statement with several. `once`: the statement is met once in the phase, so only one of its ways is taken."""

    statement: ir.Stmt
    way: int
    once: bool


class Target(Record):
    """What is written: the place of an agent or a mover, or a field of something; `entries` of a row, None for any of them."""

    of: Literal["agent", "cell", "mover", "world", "place"]
    name: str = ""
    entries: tuple[str | None, ...] = ()


class Write(Record, eq=False):
    """One `set`, `add` or change of place.

    owner: whose field or place (None: the world's). keys: the agents that name an entry, None for an entry named in another way.
    value: what two equal writes share.
    """

    sort: Literal["set", "add", "place"]
    target: Target
    kinds: tuple[str, ...]
    owner: ir.Expr | None
    value: Form
    depends: frozenset[str]
    statement: ir.Stmt
    quantifiers: tuple[Quantifier, ...]
    branches: tuple[Branch, ...]
    facts: tuple[Fact, ...]
    bounded: bool = False
    keys: tuple[ir.Member | None, ...] = ()

    @property
    def own_names(self) -> frozenset[str]:
        """The variables that name the target: its owner, and the agents that name its entry."""
        owner = (self.owner,) if isinstance(self.owner, ir.Member) else ()
        return frozenset(member.name for member in (*owner, *self.keys) if member is not None)

    @cached_property
    def about_target(self) -> tuple[Fact, ...]:
        """The known conditions that speak of the target alone, under a name that two writes share."""
        if self.owner is not None and not isinstance(self.owner, ir.Member):
            return ()
        target = {member.name: f"entry {place}" for place, member in enumerate(self.keys) if member is not None}
        target |= {} if self.owner is None else {self.owner.name: "target"}
        return tuple(Fact(f.condition, target) for f in self.facts if {v.name for v in free_variables(f.condition)} <= target.keys())
