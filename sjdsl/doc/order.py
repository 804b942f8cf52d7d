"""Differences in the order of events: phases added, removed, moved."""

from collections.abc import Sequence

from sjdsl.compiler import ir
from sjdsl.doc.changes import Change


def schedule_changes(old: ir.Game, new: ir.Game) -> list[Change]:
    """Returns the phases that only one game has, and as few others as have moved."""
    before, after = labels(old), labels(new)
    if before == after:
        return []
    found = [Change(f"phase {name}", old=before.index(name) + 1, shown=(_place(before, name), "")) for name in before if name not in after]
    found += [Change(f"phase {name}", new=after.index(name) + 1, shown=("", _place(after, name))) for name in after if name not in before]
    common = [name for name in after if name in before]
    stay = longest_rising([before.index(name) for name in common])
    for name in common:
        if before.index(name) not in stay:
            places = (_place(before, name), _place(after, name))
            found.append(Change(f"phase {name}", before.index(name) + 1, after.index(name) + 1, shown=places))
    return found


def labels(game: ir.Game) -> list[str]:
    """Returns the names of the turns of a step in order."""
    return [turn.label if isinstance(turn, ir.Phase) else "tick" for turn in game.schedule]


def longest_rising(numbers: Sequence[int]) -> list[int]:
    """Returns the longest part of different numbers that rises; of several the one that ends first."""
    best: list[list[int]] = []  # best[i]: the longest part that ends with numbers[i]
    for i, last in enumerate(numbers):
        before = max((part for part, n in zip(best, numbers[:i], strict=True) if n < last), key=len, default=[])
        best.append([*before, last])
    return max(best, key=len, default=[])


def _place(order: Sequence[str], name: str) -> str:
    """Returns `place 3, after walk`."""
    place = order.index(name)
    return f"place {place + 1}, " + (f"after {order[place - 1]}" if place else "at the beginning")
