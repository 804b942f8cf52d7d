"""One change between two games, and comparisons of lists of lines and of tables by name."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from typing import Any

from sjdsl.doc.wording import Line, bullets

Marked = tuple[str, str]  # `-`, `+` or a blank, and a line


@dataclass(frozen=True)
class Change:
    """One thing that differs.

    old, new: its values, None where there is none; shown: how they read, without it as they are; lines: for texts the lines
    that are gone and those that are new, with the lines they stand under.
    """

    what: str
    old: Any = None
    new: Any = None
    shown: tuple[str, str] = ("", "")
    unit: str = ""
    lines: tuple[Marked, ...] = ()


@dataclass(frozen=True)
class Section:
    """The changes in one part of the rules."""

    title: str
    changes: tuple[Change, ...]


def by_name(sides: Iterable[Mapping[str, Any]], unit: str = "") -> list[Change]:
    """Returns what is added, removed and different of an old and a new mapping, in the order of the old names, then the new ones."""
    old, new = sides
    names = dict.fromkeys([*old, *new])
    return [Change(name, old.get(name), new.get(name), unit=unit) for name in names if old.get(name) != new.get(name)]


def texts(what: str, old: Sequence[Line] | Sequence[str], new: Sequence[Line] | Sequence[str]) -> list[Change]:
    """Returns at most one change: the lines that differ between two texts."""
    before, after = (_written(lines) for lines in (old, new))
    if before == after:
        return []
    merged: list[Marked] = []  # both texts as one
    for sort, i, j, k, m in SequenceMatcher(None, before, after, autojunk=False).get_opcodes():
        if sort == "equal":
            merged += [(" ", line) for line in before[i:j]]
        else:
            merged += [("-", line) for line in before[i:j]] + [("+", line) for line in after[k:m]]
    return [Change(what, list(before), list(after), lines=tuple(_with_parents(merged)))]


def whole_texts(what: str, old: Sequence[str], new: Sequence[str]) -> Change:
    """Returns the change of one text into another, each as a whole: of pictures single lines say nothing."""
    return Change(what, list(old), list(new), lines=(*(("-", line) for line in old), *(("+", line) for line in new)))


def _written(lines: Sequence[Line] | Sequence[str]) -> list[str]:
    """Returns texts as they are, and sentences as the lines of a list without its signs."""
    return [text for line in lines for text in ([line] if isinstance(line, str) else (b.replace("- ", "", 1) for b in bullets([line])))]


def _with_parents(merged: Sequence[Marked]) -> list[Marked]:
    """Returns the marked lines and, of the others, those that a marked line stands under."""
    kept: set[int] = set()
    for place, (sign, line) in enumerate(merged):
        if sign == " ":
            continue
        kept.add(place)
        depth = _depth(line)
        for above in range(place - 1, -1, -1):
            if merged[above][0] == " " and _depth(merged[above][1]) < depth:
                kept.add(above)
                depth = _depth(merged[above][1])
    return [merged[place] for place in sorted(kept)]


def _depth(line: str) -> int:
    return len(line) - len(line.lstrip(" "))
