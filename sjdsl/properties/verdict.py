"""What became of a promise: kept or broken, how that is known, and the trace that shows it."""

from dataclasses import dataclass
from typing import Literal

How = Literal["decided", "proved", "examples", "episodes", "not decided"]


@dataclass(frozen=True)
class Verdict:
    """One promise of a game.

    text: as written, on one line; file, line: where. kept: None if it could not be put to the test.
    untested: of a kept one, the lines it depends on that never ran in any course: then nothing speaks against it, and too little for it.
    how: `decided` when compiled; `proved` without playing; `examples` on random small maps, and episodes on the game's own; `episodes` of
      the scripted policies. said: the same in words, with bounds. trace: how it breaks, step by step. figures: numbers behind `said`.
    """

    text: str
    file: str
    line: int
    kept: bool | None
    how: How
    said: str
    trace: tuple[str, ...] = ()
    untested: tuple[str, ...] = ()

    @property
    def word(self) -> Literal["kept", "untested", "broken", "not decided"]:
        """What became of the promise, in a word."""
        if self.kept:
            return "untested" if self.untested else "kept"
        return "broken" if self.kept is False else "not decided"


@dataclass(frozen=True)
class Effort:
    """How hard promises are tried: courses on small maps, episodes on the own map of random play (0: none), the seed of both.

    tries: courses played to make one that breaks a promise as simple as it can be.
    """

    examples: int = 400
    episodes: int = 10
    seed: int = 0
    tries: int = 600
