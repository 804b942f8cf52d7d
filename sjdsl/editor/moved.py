"""Where the places of a text are after an edit: what stands in front of the change stays, what stands behind it moves along."""

from collections.abc import Iterable


class Moved:
    """One change between two texts: the part in which they differ."""

    def __init__(self, before: str, after: str):
        most = min(len(before), len(after))
        self._front = _alike(before, after)
        self._behind = len(before) - min(_alike(reversed(before), reversed(after)), most - self._front)
        self._by = len(after) - len(before)

    def start(self, at: int) -> int:
        """Returns where what begins at a character begins now; of what was changed itself, where the change begins."""
        return at + self._by if at >= self._behind else min(at, self._front)

    def end(self, at: int) -> int:
        """Returns where what ends at a character ends now; of what was changed itself, where the change begins."""
        return at if at <= self._front else self.start(at)

    def back(self, at: int) -> int:
        """Returns where a character of the new text was before; one that is new, where the change begins."""
        if at <= self._front:
            return at
        return at - self._by if at - self._by >= self._behind else self._front


def _alike(a: Iterable[str], b: Iterable[str]) -> int:
    """Returns how many characters are the same before the first that differ."""
    count = 0
    for x, y in zip(a, b, strict=False):
        if x != y:
            break
        count += 1
    return count
