"""Accounts of a step for traces.

Which statement wrote what, in which instance, after which random draws.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

from sjdsl.compiler import ir
from sjdsl.interpreter.state import Value, World


class Drawn(NamedTuple):
    """32 random bits that a statement drew, and the result."""

    statement: "ir.Chance | ir.Draw | ir.Pick | ir.Match"
    number: int  # of the draw in the statement's stream
    bits: int
    # The number of the branch of a chance, None for none; the value of a `draw`; whether a member
    # was picked or a pair matched.
    result: Value
    bounds: tuple[int, ...] = ()  # the thresholds of a chance, of 2^31, one for each branch
    names: Mapping[str, Value] = {}  # the variables around it, and those of the member or pair


@dataclass(frozen=True)
class Done:
    """A statement that writes, and was performed in one instance."""

    statement: ir.Stmt
    names: Mapping[str, Value]  # the variables around it
    causes: tuple[Drawn, ...]  # the draws it depends on, outermost first
    written: Mapping[str, tuple[Any, ...]]  # its writes, by the name of the list in `Writes`


@dataclass(frozen=True)
class Account:
    """One turn of the schedule (or the phase `start`).

    The states before and after it, and its writes and draws, in order.
    """

    turn: "ir.Phase | ir.Tick"
    before: World
    after: World
    done: tuple[Done, ...] = ()
    drawn: tuple[Drawn, ...] = ()
    actions: tuple[int, ...] = ()  # of each agent; `stay` in place of a forbidden one


Tell: TypeAlias = Callable[[Account], None]
