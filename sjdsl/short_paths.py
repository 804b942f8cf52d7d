"""Names paths by the parts in which they differ."""

from collections.abc import Iterable
from itertools import takewhile
from pathlib import Path


def short_names(names: Iterable[str]) -> dict[str, str]:
    """Returns a short name for each path among some names; no two are the same.

    It is the path without what all of them end in, and without the folders that aren't needed to tell them apart: `a` for `runs/a/cell`
    beside `runs/b/cell`. Other names, such as `random`, stay as they are.
    """
    whole = dict.fromkeys(names)
    paths = {name: parts for name in whole if len(parts := Path(name).parts) > 1}
    if not paths:
        return {name: name for name in whole}
    from_the_end = zip(*(parts[::-1] for parts in paths.values()), strict=False)
    ending = sum(
        1 for _ in takewhile(lambda parts: len(paths) > 1 and len({*parts}) == 1, from_the_end)
    )
    ending = min(ending, *(len(parts) - 1 for parts in paths.values()))
    kept = {name: parts[: len(parts) - ending] for name, parts in paths.items()}
    for depth in range(1, max(map(len, kept.values())) + 1):
        short = {name: str(Path(*kept[name][-depth:])) if name in kept else name for name in whole}
        if len({*short.values()}) == len(whole):
            return short
    return {name: name for name in whole}  # two of them are the same path, written differently
