"""Decides when the next checkpoint is due, so that writing them takes a small share of the time.

The state of a run may be small, or hold a replay buffer of gigabytes. Either is written often
enough that little is lost when a process is killed, but takes at most a given share of the run's
time.
"""

from ..settings.config import Config

SECONDS_A_MINUTE = 60.0


class CheckpointPace:
    """The times at which checkpoints of a run are due. Times are seconds of one clock."""

    def __init__(self, config: Config, now: float) -> None:
        self._config = config
        self._cost = 0.0  # seconds that the last one took
        self._last = now  # when the last one was written, or the run began

    @property
    def interval(self) -> float:
        """The least seconds from the end of one checkpoint to the start of the next."""
        return max(
            SECONDS_A_MINUTE * self._config.checkpoint_minutes,
            self._cost / self._config.checkpoint_share - self._cost,
        )

    def is_due(self, update: int, now: float) -> bool:
        """Whether to write a checkpoint after an update."""
        if self._config.checkpoint_updates:
            return update % self._config.checkpoint_updates == 0
        return now - self._last >= self.interval

    def written(self, began: float, ended: float) -> None:
        """Notes that a checkpoint was written."""
        self._cost = ended - began
        self._last = ended
