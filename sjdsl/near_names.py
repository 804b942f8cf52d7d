"""Suggests known names that are close to a misspelt one; imports nothing, so that it is fast."""

from collections.abc import Iterable


def meant(name: str, known: Iterable[str], those: str = "there are") -> str:
    """Returns the end of a message about an unknown name: the nearest known one, or all of them; nothing if none are known.

    Args:
      those: how the list of all begins: `; the bundled games are coins, clean_up`; empty for no list.
    """
    names = list(dict.fromkeys(known))
    near = nearest(name, names)
    if near:
        return f"; did you mean `{near}`?"
    return f"; {those} {', '.join(names)}" if names and those else ""


def nearest(name: str, candidates: Iterable[str]) -> str:
    """Returns the other candidate closest to `name` by edit distance, or `""` if none is close enough to be meant."""
    best, best_distance = "", max(1, len(name) // 3) + 1
    for candidate in sorted(set(candidates) - {name}):
        distance = _distance(name, candidate)
        if distance < best_distance:
            best, best_distance = candidate, distance
    return best


def _distance(a: str, b: str) -> int:
    """Returns the optimal string alignment distance: insert, delete, replace, swap neighbours."""
    rows = [list(range(len(b) + 1))]
    for i, x in enumerate(a, 1):
        row = [i]
        for j, y in enumerate(b, 1):
            cost = min(rows[-1][j] + 1, row[j - 1] + 1, rows[-1][j - 1] + (x != y))
            if i > 1 and j > 1 and x == b[j - 2] and a[i - 2] == y:
                cost = min(cost, rows[-2][j - 2] + 1)
            row.append(cost)
        rows.append(row)
    return rows[-1][-1]
