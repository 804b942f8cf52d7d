"""The verdict on a check: passed, untested, failed or not decided, how that is known, and the trace that shows it."""

from dataclasses import dataclass
from typing import Literal

from sjdsl.properties.trajectory import Scenario

How = Literal["decided", "proved", "examples", "episodes", "not decided"]


@dataclass(frozen=True)
class Verdict:
    """The verdict on one check of a game.

    text: as written, on one line; file, line: where. passed: None if it could not be tested.
    untested: lines that a passed check depends on and that never ran in any trajectory. Then a fault in them would not have been seen.
    unreached: for an `expect`, those that never ran in its own episodes.
    how: `decided` when compiled; `proved` without playing; `examples` in random trajectories, and episodes on the game's own map;
      `episodes` of the scripted policies. reason: the same in words, with confidence bounds. trace: the counterexample, step by step.
    scenario: what leads to the counterexample when it is played on the interpreter, every action written out; None where nothing is played.
    note: how the check fails on a map that was made for the test; none of that kind was found on the game's own map.
    """

    text: str
    file: str
    line: int
    passed: bool | None
    how: How
    reason: str
    trace: tuple[str, ...] = ()
    untested: tuple[str, ...] = ()
    unreached: tuple[str, ...] = ()
    scenario: Scenario | None = None
    note: "Verdict | None" = None

    @property
    def status(self) -> Literal["passed", "untested", "failed", "not decided"]:
        """The verdict in a word."""
        if self.passed:
            return "untested" if self.untested else "passed"
        return "failed" if self.passed is False else "not decided"


@dataclass(frozen=True)
class Effort:
    """The effort of a test: random trajectories on small maps, to which the steps of the worlds on the own map are in proportion; whole
    episodes there at least (0: no worlds); the seed of both.

    tries: trajectories played to shrink one counterexample. any_map: a counterexample on any map refutes a check.
    """

    examples: int = 200
    episodes: int = 10
    seed: int = 0
    tries: int = 600
    any_map: bool = False
