"""One instance of a statement.

It has the snapshot it reads, its variable bindings, and its number among all instances.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeVar

from sjdsl.compiler import ir
from sjdsl.interpreter.account import Drawn
from sjdsl.interpreter.board import Board
from sjdsl.interpreter.state import Value, World
from sjdsl.interpreter.threefry import Draws, take

T = TypeVar("T")


@dataclass(frozen=True)
class Instance:
    """The context in which expressions are evaluated and statements are performed."""

    board: Board
    world: World  # the snapshot
    actions: tuple[int, ...] = ()  # one for each agent, after `forbid`
    draws: Draws | None = None  # None where nothing may be drawn
    names: Mapping[str, Value] = field(default_factory=dict)  # variables
    number: int = 0
    # For checks: (event, its enum value or None) -> its count so far.
    totals: Mapping[tuple[str, str | None], int] = field(default_factory=dict)
    # Cache of values that are the same in every instance on this state, by identity of the
    # expression.
    known: dict[int, tuple[ir.Expr, Value]] = field(default_factory=dict)
    causes: tuple[Drawn, ...] = ()  # the draws that led to this instance, outermost first
    earlier: "Instance | None" = None  # for checks: one on the state before the step

    def binding(self, names: Mapping[str, Value]) -> "Instance":
        """Returns this instance with more variables and the same number."""
        return self._with({**self.names, **names}, self.number)

    def for_member(self, names: Mapping[str, Value], digit: int, radix: int) -> "Instance":
        """Returns the instance for one member of a quantifier written inside this one.

        Args:
          names: the variables that the member binds.
          digit: its number among the `radix` possible members.
        """
        assert 0 <= digit < radix, (digit, radix)
        return self._with({**self.names, **names}, self.number * radix + digit)

    def only(self, names: Mapping[str, Value]) -> "Instance":
        """Returns an instance on the same state in which only these variables exist."""
        return self._with(names, 0)

    def because(self, drawn: Drawn) -> "Instance":
        """Returns this instance with one more draw among its causes."""
        return self._with(self.names, self.number, (*self.causes, drawn))

    def _with(
        self, names: Mapping[str, Value], number: int, causes: tuple[Drawn, ...] | None = None
    ) -> "Instance":
        """Returns an instance on the same state with other variables, number and causes."""
        causes = self.causes if causes is None else causes
        return Instance(
            board=self.board,
            world=self.world,
            actions=self.actions,
            draws=self.draws,
            names=names,
            number=number,
            totals=self.totals,
            known=self.known,
            causes=causes,
            earlier=self.earlier,
        )

    def bits(self, stream: int, number: int) -> int:
        """Returns the 32 random bits `number` of a stream of this step."""
        assert self.draws is not None, "a draw where nothing may be drawn"
        return self.draws.bits(stream, number)

    def take(self, stream: int, number: int, left: list[T]) -> tuple[T, int]:
        """Removes one element of a list by the random bits `number` of a stream; returns both."""
        assert self.draws is not None, "a draw where nothing may be drawn"
        return take(self.draws, stream, number, left)
