"""Aligns declarations of one sort on neighbouring lines: names, units and values in columns."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

from sjdsl.format.flat import Flat
from sjdsl.format.gaps import Gap
from sjdsl.format.structure import Structure

Range = tuple[int, int]


def shared_columns(runs: Sequence[Sequence[Range]], indent: int, flat: Flat, structure: Structure, gaps: Sequence[Gap]) -> dict[int, int]:
    """Returns how many spaces more some tokens need. `runs`: the items of each line; only those alone on their line take part.

    Neighbours that cannot all have the columns without longer lines than allowed have none.
    """
    found: dict[int, int] = {}
    for together in _neighbours(runs, structure, gaps):
        more = _more_spaces([(start, *structure.columns[start][1]) for start, _ in together], flat)
        if all(_has_room(start, end, indent, more, flat, structure) for start, end in together):
            found |= more
    return found


def _neighbours(runs: Sequence[Sequence[Range]], structure: Structure, gaps: Sequence[Gap]) -> Iterator[list[Range]]:
    """Yields the items that share columns: of one sort, line below line, no blank line between."""
    together: list[Range] = []
    for run in runs:
        start = run[0][0]
        sort = structure.columns[start][0] if len(run) == 1 and start in structure.columns else ""
        is_next = together and structure.columns[together[0][0]][0] == sort and not _is_apart(gaps[start])
        if together and not is_next:
            yield together
            together = []
        together += [run[0]] if sort else []
    if together:
        yield together


def _is_apart(gap: Gap) -> bool:
    return gap.blank or any(comment.blank for comment in gap.comments)


def _more_spaces(cells: Sequence[Sequence[int]], flat: Flat) -> dict[int, int]:
    """Returns the spaces that make each cell as wide as the widest one above or below. A row: first tokens of its cells."""
    widths = [[flat.width(a, b - 1) for a, b in pairwise(row)] for row in cells]
    widest = [max(column) for column in zip(*widths, strict=True)]
    return {
        token: wide - width for row, own in zip(cells, widths, strict=True) for token, width, wide in zip(row[1:], own, widest, strict=True)
    }


def _has_room(start: int, end: int, indent: int, more: dict[int, int], flat: Flat, structure: Structure) -> bool:
    """Returns whether the first line of an item, which holds all its columns, is short enough with them."""
    stops = structure.columns[start][1]
    if not flat.fits(start, end, indent):
        end = next((n for n in range(stops[-1], end + 1) if n in structure.containers), end)
    return flat.fits(start, end, indent + sum(more[stop] for stop in stops))
