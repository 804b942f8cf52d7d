"""The verdict on a check: passed, untested, failed or not decided, how that is known, and the trace that shows it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

from sjdsl.compiler import ir
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.trajectory import Scenario

Progress = Callable[[str], None]  # is told now and then how far a test is
How = Literal["decided", "proved", "examples", "episodes", "not decided"]


@dataclass(frozen=True)
class Verdict:
    """The verdict on one check of a game.

    text: as written, on one line; file, line: where. passed: None if it could not be tested.
    untested: lines that a passed check depends on and that never ran in random play. Then a fault in them would not have been seen.
    how: `decided` when compiled; `proved` without playing; `examples` in random play; `episodes` of the policies that an `expect` names.
    reason: the same in words, with confidence bounds. trace: the counterexample.
    scenario: what leads to the counterexample when it is played on the interpreter, every action written out; None where nothing is played.
    """

    text: str
    file: str
    line: int
    passed: bool | None
    how: How
    reason: str
    trace: tuple[str, ...] = ()
    untested: tuple[str, ...] = ()
    scenario: Scenario | None = None

    @property
    def status(self) -> Literal["passed", "untested", "failed", "not decided"]:
        """The verdict in a word."""
        if self.passed:
            return "untested" if self.untested else "passed"
        return "failed" if self.passed is False else "not decided"


@dataclass(frozen=True)
class Effort:
    """The effort of a test: how much random play, in units of 10 steps on the interpreter and 655,360 cell updates of the compiled game, and its seed.

    compiled: whether the compiled game is played; it is not where JAX is not installed. full: whether a counterexample tells every change
    of its last step, not only a few of those that are alike.
    """

    examples: int = 200
    seed: int = 0
    compiled: bool = True
    full: bool = False


def make_verdict(
    family: GameFamily,
    node: ir.Node,
    passed: bool | None,
    how: How,
    reason: str,
    trace: Sequence[str] = (),
    untested: tuple[str, ...] = (),
    scenario: Scenario | None = None,
) -> Verdict:
    """Returns a verdict on a check, or on a statement, with the file and line where it is written."""
    file, line = ("", 0) if node.origin is None else (node.origin.file, node.origin.line)
    return Verdict(
        family.text_of(node), file, line, passed, how, reason, tuple(trace), untested, scenario
    )
