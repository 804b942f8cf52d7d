"""Accounts of a step for traces: which statement wrote what, in which instance, after which random draws."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

from sjdsl.compiler import ir
from sjdsl.interpreter.state import Value, World


class Drawn(NamedTuple):
    """One word that a statement drew, and what came of it.

    number: of the word in the statement's stream. bounds: the thresholds of a chance, of 2^31, one for each branch.
    result: the number of the branch of a chance, None for none; the value of a `draw`; whether a member was picked or a pair matched.
    names: the variables around it, the member's or pair's own among them.
    """

    statement: "ir.Chance | ir.Draw | ir.Pick | ir.Match"
    number: int
    word: int
    result: Value
    bounds: tuple[int, ...] = ()
    names: Mapping[str, Value] = {}


@dataclass(frozen=True)
class Done:
    """A statement that happened in one instance and writes.

    names: the variables around it. causes: the draws without which it would not have happened, outermost first.
    written: what it added, by the name of the list in `Writes`.
    """

    statement: ir.Stmt
    names: Mapping[str, Value]
    causes: tuple[Drawn, ...]
    written: Mapping[str, tuple[Any, ...]]


@dataclass(frozen=True)
class Account:
    """One turn of the schedule (or the phase `start`): the states around it, what was written and what was drawn in it, in order.

    actions: of each agent, those that are forbidden already `stay`.
    """

    turn: "ir.Phase | ir.Tick"
    before: World
    after: World
    done: tuple[Done, ...] = ()
    drawn: tuple[Drawn, ...] = ()
    actions: tuple[int, ...] = ()


Tell: TypeAlias = Callable[[Account], None]
