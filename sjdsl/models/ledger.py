"""What an agent's own actions have paid so far."""

from collections import Counter, defaultdict

from sjdsl.doc.wording import number
from sjdsl.told.phrases import shortest

MOST_LINES = 30


class Ledger:
    """The mean reward of an agent's own actions; a step counts by what was on its end."""

    def __init__(self) -> None:
        self._times: Counter[str] = Counter()
        self._sums: defaultdict[str, float] = defaultdict(float)

    def add(self, deed: str, reward: float) -> None:
        """Counts a deed, an action such as `zap` or the cell that a step led to, and its reward."""
        self._times[deed] += 1
        self._sums[deed] += reward

    def lines(self) -> list[str]:
        """Returns what was done most often, each with its mean reward."""
        lines = []
        for deed, times in self._times.most_common(MOST_LINES):
            mean = number(shortest(round(self._sums[deed] / times, 4)))
            lines.append(f"{deed}: {mean} ({times}x)")
        return lines
