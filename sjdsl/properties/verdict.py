"""The verdict on a check, how it is known, and the trace that shows it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

from sjdsl.compiler import ir
from sjdsl.properties.instances import GameFamily
from sjdsl.properties.trajectory import Scenario

Progress = Callable[[str], None]  # called now and then with how far a test is
How = Literal["decided", "proved", "examples", "episodes", "not decided"]


@dataclass(frozen=True)
class Verdict:
    """The verdict on one check of a game.

    text: the check as written, on one line; file, line: where.
    passed: None if it could not be tested.
    how: `decided` when compiled; `proved` without playing; `examples` in random play; `episodes`
    under the policies that an `expect` names. reason: the same in words, with confidence bounds.
    trace: the counterexample.
    untested: lines that a passed check depends on and that never ran in random play. A fault in
    them would not have been seen.
    scenario: leads to the counterexample on the interpreter, with every action written out; None
    where nothing is played.
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
    """The effort of a test.

    examples: how much random play, in units of 10 steps on the interpreter and 655,360 cell updates
    of the compiled game.
    compiled: whether the compiled game is played, if JAX is installed.
    full: whether a counterexample tells every change of its last step, not only a few of those that
    are alike.
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
    scenario: Scenario | None = None,
) -> Verdict:
    """Returns a verdict on a check or a statement, with the file and line where it is."""
    return Verdict(
        text=family.text_of(node),
        file="" if node.origin is None else node.origin.file,
        line=0 if node.origin is None else node.origin.line,
        passed=passed,
        how=how,
        reason=reason,
        trace=tuple(trace),
        scenario=scenario,
    )
