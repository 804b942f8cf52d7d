"""Names seeds in sentences, so that what is true of several of them is said once."""

from collections.abc import Hashable, Iterable
from typing import TypeVar

Said = TypeVar("Said", bound=Hashable)


def seeds_in_words(seeds: Iterable[int]) -> str:
    """Returns `seed 3`, `seeds 0 and 1`, or `seeds 0 to 4, 7 and 9`."""
    ranges: list[list[int]] = []  # the first and the last of consecutive seeds
    for seed in sorted(seeds):
        if ranges and seed == ranges[-1][1] + 1:
            ranges[-1][1] = seed
        else:
            ranges.append([seed, seed])
    parts: list[str] = []
    for first, last in ranges:
        if last - first < 2:
            parts += map(str, range(first, last + 1))
        else:
            parts.append(f"{first} to {last}")
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
