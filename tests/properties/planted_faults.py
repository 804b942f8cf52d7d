"""How soon the search finds each planted fault: `python -m tests.properties.planted_faults 0 1 2` for these seeds."""

import sys
import time
from pathlib import Path

from sjdsl.compiler.syntax.read import read_source
from sjdsl.properties import Effort, GameFamily
from sjdsl.properties.monitors import STATES
from sjdsl.properties.search import Search, violation_in_states

FOLDER = Path(__file__).parent / "planted"
GAMES = tuple(sorted(path.stem for path in FOLDER.glob("*.sj")))


def planted(game: str, variant: str | None = "fault") -> GameFamily:
    """Returns a game with its fault; without, for None."""
    return GameFamily(read_source(FOLDER / f"{game}.sj"), (variant,) if variant else ())


def trajectories_until_found(game: str, seed: int, most: int = Effort.examples) -> int | None:
    """Returns after how many trajectories the fault of a game is found; None if it is not within `most`."""
    family = planted(game)
    numbers = [i for i, check in enumerate(family.own.checks) if check.sort in STATES]
    search = Search(family, numbers, Effort(examples=most, seed=seed, tries=0), violation_in_states, {})
    while not search.found and search.record.number < most:
        search.one()
    return search.record.number if search.found else None


if __name__ == "__main__":
    for name in GAMES:
        for chosen in map(int, sys.argv[1:] or ["0"]):
            start = time.process_time()
            print(name, chosen, trajectories_until_found(name, chosen), f"{time.process_time() - start:.1f} s", flush=True)
