"""Names seeds in sentences, so that what is true of several of them is said once."""

from collections.abc import Hashable, Iterable
from itertools import groupby
from typing import TypeVar

Said = TypeVar("Said", bound=Hashable)


def seeds_in_words(seeds: Iterable[int]) -> str:
    """Returns `seed 3`, `seeds 0 and 1`, or `seeds 0 to 4, 7 and 9`."""
    parts: list[str] = []
    # consecutive seeds differ by as much as their positions
    for _, pairs in groupby(enumerate(sorted(seeds)), lambda pair: pair[1] - pair[0]):
        consecutive = [seed for _, seed in pairs]
        if len(consecutive) > 2:
            parts.append(f"{consecutive[0]} to {consecutive[-1]}")
        else:
            parts += map(str, consecutive)
    *before, end = parts
    if before:
        return f"seeds {', '.join(before)} and {end}"
    return f"seeds {end}" if "to" in end else f"seed {end}"


def seeds_of_each(pairs: Iterable[tuple[int, Said]]) -> dict[Said, list[int]]:
    """Returns each thing that is said of seeds, with the seeds that it is said of.

    Args:
      pairs: a seed, and a thing that is said of it.
    """
    seeds_of: dict[Said, list[int]] = {}
    for seed, thing in pairs:
        seeds_of.setdefault(thing, []).append(seed)
    return seeds_of
