"""Prints differences between games for a person, or as JSON values."""

from collections.abc import Sequence
from typing import Any

from sjdsl.doc.changes import Change, Section
from sjdsl.doc.wording import number
from sjdsl.doc.written import Written


def name_of(w: Written) -> str:
    """Returns `yard`, `yard, variant crowd`."""
    return w.game.name + (f", variant {'+'.join(w.chosen)}" if w.chosen else "")


def report(old: Written, new: Written, sections: Sequence[Section]) -> str:
    """Returns the differences as text."""
    head = [f"{name_of(old)}  ->  {name_of(new)}"]
    if not sections:
        return "\n".join([*head, "nothing differs", ""])
    found = head
    for section in sections:
        found += ["", section.title]
        for change in section.changes:
            found.append(f"  {change.what if change.lines else _sentence(change)}")
            found += [f"    {sign} {line}" for sign, line in change.lines]
    return "\n".join([*found, ""])


def _sentence(change: Change) -> str:
    values = [number(value) if isinstance(value, int | float) else str(value) for value in (change.old, change.new)]
    old, new = (shown or value for shown, value in zip(change.shown, values, strict=True))
    unit = f" ({change.unit})" if change.unit else ""
    if change.old is None:
        return f"{change.what}: added, {new}{unit}"
    if change.new is None:
        return f"{change.what}: removed, was {old}{unit}"
    return f"{change.what}: {old} -> {new}{unit}"


def as_json(old: Written, new: Written, sections: Sequence[Section]) -> dict[str, Any]:
    """Returns the differences as plain values: for texts the lines that are gone and new, else the old and new value."""
    games = {
        side: {"game": w.game.name, "file": w.file, "variants": list(w.chosen), "title": w.game.title}
        for side, w in (("old", old), ("new", new))
    }
    found = [{"section": s.title, "changes": [_change(c) for c in s.changes]} for s in sections]
    return {**games, "differs": bool(sections), "sections": found}


def _change(change: Change) -> dict[str, Any]:
    if change.lines:
        marked = {name: [line.strip() for sign, line in change.lines if sign == mark] for name, mark in (("removed", "-"), ("added", "+"))}
        return {"what": change.what, **marked}
    unit = {"unit": change.unit} if change.unit else {}
    return {"what": change.what, "old": change.old, "new": change.new, **unit}
