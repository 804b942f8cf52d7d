"""Names seeds in sentences, so that what is true of several of them is said once."""

from collections.abc import Hashable, Iterable
from typing import TypeVar

Said = TypeVar("Said", bound=Hashable)


def seeds_in_words(seeds: Iterable[int]) -> str:
    """Returns `seed 3`, `seeds 0 and 1`, or `seeds 0 to 4, 7 and 9`."""
    rows: list[list[int]] = []  # of consecutive seeds
    for seed in sorted(seeds):
        if rows and seed == rows[-1][-1] + 1:
            rows[-1].append(seed)
        else:
            rows.append([seed])
    parts: list[str] = []
    for row in rows:
        parts += map(str, row) if len(row) < 3 else [f"{row[0]} to {row[-1]}"]
    *first, last = parts
    if first:
        return f"seeds {', '.join(first)} and {last}"
    return f"seeds {last}" if "to" in last else f"seed {last}"


def seeds_of_each(pairs: Iterable[tuple[int, Said]]) -> dict[Said, list[int]]:
    """Returns each thing that is said of seeds, with the seeds that it is said of.

    Args:
      pairs: a seed, and a thing that is said of it.
    """
    seeds_of: dict[Said, list[int]] = {}
    for seed, thing in pairs:
        seeds_of.setdefault(thing, []).append(seed)
    return seeds_of
