"""Suggests known names that are close to a misspelt one."""

from collections.abc import Iterable
from difflib import get_close_matches

ALIKE = 0.66  # the least share of letters that two names must have in common: two of three


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
    """Returns the other candidate that is most like `name`, or `""` if none is close enough to be meant."""
    return next(iter(get_close_matches(name, sorted(set(candidates) - {name}), 1, ALIKE)), "")
