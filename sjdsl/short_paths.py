"""Names paths by the parts in which they differ."""

from collections.abc import Iterable, Sequence
from pathlib import Path


def short_names(names: Iterable[str]) -> dict[str, str]:
    """Returns a short name for each path among some names; no two are the same.

    It is the path without the end that all paths share, and without leading folders that aren't
    needed: `a` for `runs/a/cell` beside `runs/b/cell`. Other names, such as `random`, don't change.
    """
    names = list(dict.fromkeys(names))
    paths = {name: Path(name).parts for name in names}
    paths = {name: parts for name, parts in paths.items() if len(parts) > 1}
    num_shared = _num_shared_at_end(list(paths.values()))
    kept = {name: parts[: len(parts) - num_shared] for name, parts in paths.items()}
    for depth in range(1, max(map(len, kept.values()), default=0) + 1):
        short = {name: str(Path(*kept[name][-depth:])) if name in kept else name for name in names}
        if len({*short.values()}) == len(names):
            return short
    return {name: name for name in names}  # no paths, or two ways to write one path


def _num_shared_at_end(paths: Sequence[tuple[str, ...]]) -> int:
    """Returns how many last parts all paths share, at most all but one of a path."""
    if len(paths) < 2:
        return 0
    most = min(map(len, paths)) - 1
    for number in range(most, 0, -1):
        if len({path[-number:] for path in paths}) == 1:
            return number
    return 0
