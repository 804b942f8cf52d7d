"""The loop over the updates of a stage: metrics, checkpoints and policies, whatever ends it."""

import math
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from sjdsl.termination import Terminated, sigterm_raises

from ..algorithms.training_functions import TrainState
from ..devices.processes import any_process
from ..policies.loading import Policy, trained_policy
from ..settings.config import Config
from .checkpoint_pace import CheckpointPace
from .compiled import Compiled, NoMemoryError
from .learning_signs import is_due, said_once
from .metric_rows import flatten_metrics, mean_row
from .metrics_files import Row
from .progress import Show
from .recorder import Recorder
from .run_errors import RunError
from .run_stage import RunStage
from .seeds_in_words import seeds_in_words, seeds_of_each


@dataclass(frozen=True)
class Update:
    """What a callback gets after an update."""

    number: int  # updates done
    env_steps: int  # of each seed, so far
    row: Row  # the metrics of this update; with several seeds, their means
    rows: Mapping[int, Row]  # seed -> its metrics, without seeds that have diverged
    run_dir: Path
    policy_of: Callable[[int], Policy]  # seed -> the policy as it is now

    @property
    def policy(self) -> Policy:
        """The policy as it is now, of the first seed."""
        return self.policy_of(min(self.rows))


Callback = Callable[[Update], Any]  # called after an update; the run ends there if it returns True


@dataclass
class Loop:
    """The updates of a stage, and how far they are."""

    stage: RunStage
    compiled: Compiled
    state: TrainState  # after `updates` updates
    recorders: Sequence[Recorder]  # of each seed; none in processes that don't write
    save: Callable[[int, Any], None]  # writes a checkpoint: the state after an update
    show: Show
    callback: Callback | None = None
    updates: int = 0  # done
    # seed -> the update in which its loss was not finite
    diverged: dict[int, int] = field(default_factory=dict)
    stopped: bool = False  # by its callback
    saved: int = 0  # the update of the last checkpoint
    is_whole: bool = False  # `state` is that after `updates`, and not lent to a function

    def run(self) -> None:
        """Runs the remaining updates; whatever stops them, what was done before is kept.

        Raises:
          RunError: all seeds diverged. NoMemoryError, OSError, KeyboardInterrupt: what stopped the
          run.
        """
        self.saved = self.updates
        with noting_signals() as signals:
            try:
                self._run(signals)
            except OSError:
                self.is_whole = False  # there is no room for another attempt
                raise
            except jax.errors.JaxRuntimeError as error:
                if "RESOURCE_EXHAUSTED" not in str(error):
                    raise
                raise NoMemoryError(
                    f"{str(error).splitlines()[0]}; "
                    "make num_envs, num_steps or seeds smaller, and start again"
                ) from None
            finally:
                if self.is_whole and self.updates > self.saved:
                    self._save()

    def _run(self, signals: Sequence[int]) -> None:
        """Runs the remaining updates. signals: those that have arrived; it ends at the first."""
        config = self.stage.config
        last = time.perf_counter()
        began = last - max((recorder.history.seconds for recorder in self.recorders), default=0.0)
        pace = CheckpointPace(config, last)
        while self.updates < config.num_updates and not self.stopped:
            rows = self._update(began, last)
            self._record(rows)
            self.updates += 1
            self._keep_policies()
            self.is_whole = True  # with its evaluation, which isn't repeated
            if self.recorders:
                self.show(*self._summary(rows))
            now = time.perf_counter()
            if any_process(pace.is_due(self.updates, now)):
                self._save()
                pace.written(now, time.perf_counter())
            if any_process(bool(signals)):
                if signal.SIGTERM in signals:
                    raise Terminated
                raise KeyboardInterrupt
            self.stopped = any_process(self._call_back(rows))
            # Evaluating, saving and callbacks don't count as part of an update.
            last = time.perf_counter()

    def _update(self, began: float, last: float) -> list[Row]:
        """Plays and learns; returns the row of each seed.

        began, last: when the run and this update began, by the clock.
        """
        config = self.stage.config
        number = self.updates + 1
        self.is_whole = False
        self.state, played = self.compiled.collect(self.state)
        jax.block_until_ready(played)
        acted = time.perf_counter()
        self.state, metrics = self.compiled.learn(self.state, played)
        metrics = jax.device_get(metrics)
        now = time.perf_counter()
        shared = {
            "update": number,
            "env_steps": self.stage.steps_after(number),
            "seconds": now - began,
            "steps_per_second": config.steps_per_update * config.seeds / (now - last),
            "rollout_share": (acted - last) / (now - last),
        }
        if self.stage.number:
            shared["stage"] = self.stage.number
        return [
            shared | flatten_metrics(of_seed(metrics, index, config))
            for index in range(config.seeds)
        ]

    def _learning(self) -> list[int]:
        """Returns the indices of the seeds that haven't diverged."""
        seeds = self.stage.config.seed_numbers
        return [index for index, seed in enumerate(seeds) if seed not in self.diverged]

    def _recording(self) -> list[tuple[int, Recorder]]:
        """Returns the recorders of the seeds that haven't diverged, with their indices."""
        if not self.recorders:
            return []
        return [(index, self.recorders[index]) for index in self._learning()]

    def _parameters(self, index: int) -> Any:
        """Returns the parameters of a seed."""
        parameters = jax.device_get(self.compiled.parameters(self.state))
        return of_seed(parameters, index, self.stage.config)

    def _record(self, rows: Sequence[Row]) -> None:
        """Writes the rows of the seeds that are learning.

        A seed whose loss isn't finite stops alone: its parameters are still those of the update
        before (`keep_if_finite`), and are stored.

        Raises:
          RunError: all have diverged.
        """
        config = self.stage.config
        number = self.updates + 1
        bad = [index for index in self._learning() if not math.isfinite(rows[index]["loss"])]
        for index, recorder in self._recording():
            recorder.append(rows[index])
            if index in bad:
                before = f"{self.updates:08d}"
                recorder.store(self._parameters(index), self.updates, before, "last")
        self.diverged |= {config.seed_numbers[index]: number for index in bad}
        if not self._learning():
            raise RunError(
                f"{describe_divergence(self.diverged)}. "
                f"Try a smaller learning_rate than {config.learning_rate:g}"
            )

    def _keep_policies(self) -> None:
        """Evaluates and stores the policies whose turn it is."""
        number = self.updates
        every = self.stage.config.evaluate_every
        for index, recorder in self._recording():
            if every and number % every == 0:
                recorder.evaluate(self._parameters(index), number)
            if recorder.history.is_mark(number):
                recorder.mark(self._parameters(index), number)

    def _save(self) -> None:
        """Writes the last policies and a checkpoint.

        The metrics come first, so that none is missing when the run is resumed.
        """
        for index, recorder in self._recording():
            recorder.store(self._parameters(index), self.updates, "last")
        self.save(self.updates, self.state)
        self.saved = self.updates

    def _summary(self, rows: Sequence[Row]) -> tuple[Row, list[str]]:
        """Returns the mean row of the seeds that learn, and the warnings that are due.

        The row also has `before_learning`, the mean of their returns then.
        """
        warnings: dict[int, Sequence[str]] = {recorder.seed: () for recorder in self.recorders}
        shown = []
        for index, recorder in self._recording():
            history = recorder.history
            shown.append(rows[index] | {"before_learning": history.signs.before_learning})
            if is_due(self.updates, self.stage.config):
                warnings[recorder.seed] = history.warnings
        return mean_row(shown), said_once(warnings)

    def _call_back(self, rows: Sequence[Row]) -> bool:
        """Calls the callback; returns whether it ends the run."""
        if self.callback is None:
            return False
        config = self.stage.config
        seeds = config.seed_numbers
        parameters = self.compiled.parameters(self.state)

        def policy_of(seed: int) -> Policy:
            # a copy, as the next update reuses their memory
            of_one = jax.tree.map(jnp.copy, of_seed(parameters, seeds.index(seed), config))
            return trained_policy(self.stage.env, config, of_one)

        known = {seeds[index]: rows[index] for index in self._learning()}
        row = mean_row([*known.values()])
        update = Update(self.updates, row["env_steps"], row, known, self.stage.folder, policy_of)
        return self.callback(update) is True


def of_seed(tree: Any, index: int, config: Config) -> Any:
    """Returns one seed's part of a tree of all seeds."""
    if config.seeds == 1:
        return tree
    return jax.tree.map(lambda leaf: leaf[index], tree)


def diverged_before(
    state: TrainState, recorders: Sequence[Recorder], config: Config
) -> dict[int, int]:
    """Returns the seeds of a resumed state that have diverged, with their last updates."""
    diverged = np.atleast_1d(jax.device_get(state.diverged))
    # Only one process records; the numbers of updates are of no use in the others.
    updates = [recorder.history.updates for recorder in recorders] or [0] * config.seeds
    seeds = zip(config.seed_numbers, updates, diverged, strict=True)
    return {seed: update for seed, update, is_diverged in seeds if is_diverged}


def describe_divergence(diverged: Mapping[int, int]) -> str:
    """Returns which seeds diverged when, in words."""
    return "; ".join(
        f"the loss became nan in update {update} of {seeds_in_words(seeds)}; "
        f"the policy of update {update - 1} is kept"
        for update, seeds in seeds_of_each(diverged.items()).items()
    )


@contextmanager
def noting_signals() -> Iterator[Sequence[int]]:
    """Yields a list of the SIGINT (Ctrl-C) and SIGTERM that arrive, in place of what they would do.

    An update isn't interrupted, as its state couldn't be saved. A second Ctrl-C interrupts it. Off
    the main thread nothing is noted.
    """
    noted: list[int] = []
    before: dict[int, Any] = {}

    def note(number: int, _: Any) -> None:
        noted.append(number)
        if number == signal.SIGINT:
            signal.signal(number, before[number])

    if threading.current_thread() is threading.main_thread():
        numbers = [signal.SIGINT, signal.SIGTERM] if sigterm_raises() else [signal.SIGINT]
        before |= {number: signal.signal(number, note) for number in numbers}
    try:
        yield noted
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
