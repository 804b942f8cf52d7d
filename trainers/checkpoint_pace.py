"""Decides when the next checkpoint is due, so that writing checkpoints takes a small share of the time.

The state of a run may be small, or hold a replay buffer of gigabytes. Both are written so often that little is lost when a
process is killed, and so seldom that the run spends at most a share of its time on it.
"""

from .config import Config

SECONDS_A_MINUTE = 60.0
BYTES_A_SECOND = 100e6  # how fast the first checkpoint is taken to be written, with its digest; afterwards the time is measured


class CheckpointPace:
    """The times at which checkpoints of a run are due. Times are seconds of one clock."""

    def __init__(self, config: Config, num_bytes: int, now: float) -> None:
        self._config = config
        self._cost = num_bytes / BYTES_A_SECOND  # seconds that writing takes
        self._last = now  # when the last one was done, or the run began

    @property
    def interval(self) -> float:
        """Seconds from one checkpoint's end to the next one's begin, at least."""
        return max(SECONDS_A_MINUTE * self._config.checkpoint_minutes, self._cost / self._config.checkpoint_share - self._cost)

    def is_due(self, update: int, now: float) -> bool:
        """Whether a checkpoint is to be written after an update."""
        if self._config.checkpoint_updates:
            return update % self._config.checkpoint_updates == 0
        return now - self._last >= self.interval

    def written(self, began: float, ended: float) -> None:
        """Takes note of a checkpoint that was written."""
        self._cost = ended - began
        self._last = ended
