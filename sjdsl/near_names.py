"""Suggests known names that are close to a misspelt one."""

from collections.abc import Iterable
from difflib import SequenceMatcher

ALIKE = 0.66  # the least share of letters that two names must have in common: two of three


def meant(name: str, known: Iterable[str], those: str = "there are") -> str:
    """Returns the end of a message about an unknown name: the nearest known ones, or all of them; nothing if none are known.

    Args:
      those: how the list of all begins: `; the bundled games are coins, clean_up`; empty for no list.
    """
    names = list(dict.fromkeys(known))
    near = nearest(name, names)
    if near:
        return f"; did you mean {either(near)}?"
    return f"; {those} {', '.join(names)}" if names and those else ""


def nearest(name: str, candidates: Iterable[str]) -> tuple[str, ...]:
    """Returns the other candidates that are most like `name`: several if they are equally so, none if none is close enough to be meant."""
    best = ALIKE
    near: list[str] = []
    matcher = SequenceMatcher(b=name)
    for candidate in sorted(set(candidates) - {name}):
        matcher.set_seq1(candidate)
        if (
            matcher.real_quick_ratio() < best or matcher.quick_ratio() < best
        ):  # they are never less than `ratio`, which is slow
            continue
        alike = matcher.ratio()
        if alike > best:
            best = alike
            near = []
        if alike == best:
            near.append(candidate)
    return tuple(near)


def either(names: Iterable[str]) -> str:
    """Returns names as alternatives: `east` or `west`."""
    *first, last = [f"`{name}`" for name in names] or [""]
    return f"{', '.join(first)} or {last}" if first else last
