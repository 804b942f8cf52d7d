"""Suggests known names that are close to a misspelt one."""

from collections.abc import Iterable
from difflib import SequenceMatcher

LEAST_SIMILARITY = 0.66  # of a name and a suggestion: two of three letters in common


def meant(name: str, known: Iterable[str], those: str = "there are") -> str:
    """Returns the end of a message about an unknown name: the nearest known ones, or all of them.

    It is "" if none are known.

    Args:
      those: the beginning of the list of all, such as `the bundled games are`; "" for no list.
    """
    names = list(dict.fromkeys(known))
    near = nearest(name, names)
    if near:
        return f"; did you mean {either(near)}?"
    return f"; {those} {', '.join(names)}" if names and those else ""


def nearest(name: str, candidates: Iterable[str]) -> tuple[str, ...]:
    """Returns the other candidates that are most like `name`, none if none is close enough."""
    best = LEAST_SIMILARITY
    near: list[str] = []
    matcher = SequenceMatcher(b=name)
    for candidate in sorted(set(candidates) - {name}):
        matcher.set_seq1(candidate)
        # `ratio` is slow, and never larger than these.
        if matcher.real_quick_ratio() < best or matcher.quick_ratio() < best:
            continue
        similarity = matcher.ratio()
        if similarity > best:
            best = similarity
            near = []
        if similarity == best:
            near.append(candidate)
    return tuple(near)


def either(names: Iterable[str]) -> str:
    """Returns names as alternatives: `east` or `west`."""
    *first, last = [f"`{name}`" for name in names] or [""]
    return f"{', '.join(first)} or {last}" if first else last
