"""The loop over the updates of a run: metrics, checkpoints and policies, also if the run is interrupted."""

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
import numpy as np

from sjdsl.termination import Terminated, sigterm_raises

from ..algorithms.training_functions import TrainState
from ..devices.processes import any_process
from ..policies.loading import Policy
from ..settings.config import Config
from .checkpoint_pace import CheckpointPace
from .compiled import Compiled, NoMemoryError
from .learning_signs import LearningWarning, said_once
from .metric_rows import flatten_metrics, mean_row
from .metrics_files import Row
from .progress import Show
from .recorder import Recorder
from .run_errors import RunError
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
        return self.policy_of(next(iter(self.rows)))


Callback = Callable[[Update], Any]  # called after an update; the run ends there if it returns True


# Called after an update with its number, the rows of all seeds, the indices of those that learn, and the parameters; whether to end the run.
AfterUpdate = Callable[[int, Sequence[Row], Sequence[int], Any], bool]


@dataclass
class Progress:
    """The progress of a run."""

    updates: int  # done
    diverged: dict[int, int] = field(
        default_factory=dict
    )  # seed -> the update in which its loss was not finite
    stopped: bool = False  # by its callback


@dataclass(frozen=True)
class Keeping:
    """Where the updates of a run are kept and shown."""

    recorders: Sequence[Recorder]  # of each seed; none in processes that don't write
    save: Callable[[int, Any], None]  # writes a checkpoint: the state after an update
    show: Show
    after_update: AfterUpdate = lambda *_: False
    steps_before: int = 0  # environment steps of each seed in stages before this one
    stage: int = 0  # its number; 0: the run has no stages

    def recording(self, seeds: Sequence[int]) -> list[tuple[int, Recorder]]:
        """Returns the recorders of seeds, by their indices; none in processes that don't write."""
        return [(index, self.recorders[index]) for index in seeds] if self.recorders else []


def run_updates(
    compiled: Compiled, state: TrainState, progress: Progress, config: Config, keeping: Keeping
) -> TrainState:
    """Runs the remaining updates; whatever stops them, what was done before is kept.

    Args:
      state: after `progress.updates` updates.
      progress: updated after each.
    Raises:
      RunError: all seeds diverged. NoMemoryError, OSError, KeyboardInterrupt: what stopped the run.
    """
    before = max((recorder.history.seconds for recorder in keeping.recorders), default=0.0)
    began = last = time.perf_counter()
    pace = CheckpointPace(
        config, sum(leaf.size * leaf.dtype.itemsize for leaf in jax.tree.leaves(state)), began
    )
    saved = progress.updates
    whole: int | None = (
        saved  # the update after which `state` is; None while its memory is lent to a function
    )

    def save(number: int, learning: Sequence[int]) -> None:
        """Writes the last policies and a checkpoint; the metrics first, so that none is missing when the run is resumed."""
        parameters = jax.device_get(compiled.parameters(state))
        for index, recorder in keeping.recording(learning):
            recorder.store(of_seed(parameters, index, config), number, "last")
        keeping.save(number, state)

    with noting_signals() as signals:
        try:
            for number in range(progress.updates + 1, config.num_updates + 1):
                whole = None
                state, played = compiled.collect(state)
                jax.block_until_ready(played)
                acted = time.perf_counter()
                state, metrics = compiled.learn(state, played)
                measured = jax.device_get(metrics)
                now = time.perf_counter()
                start = {
                    "update": number,
                    "env_steps": keeping.steps_before + number * config.steps_per_update,
                    "seconds": before + now - began,
                    "steps_per_second": config.steps_per_update * config.seeds / (now - last),
                    "rollout_share": (acted - last) / (now - last),
                }
                start |= {"stage": keeping.stage} if keeping.stage else {}
                rows = [
                    start | flatten_metrics(of_seed(measured, index, config))
                    for index in range(config.seeds)
                ]
                parameters = compiled.parameters(state)
                learning = _record(rows, parameters, progress, config, keeping)
                progress.updates = number
                evaluates = config.evaluate_every and number % config.evaluate_every == 0
                for index, recorder in keeping.recording(learning):
                    if evaluates:
                        recorder.evaluate(
                            of_seed(jax.device_get(parameters), index, config), number
                        )
                    if recorder.history.is_mark(number):
                        recorder.mark(of_seed(jax.device_get(parameters), index, config), number)
                whole = number  # with its evaluation, which isn't repeated
                keeping.show(*_summary(rows, learning, keeping))
                if any_process(pace.is_due(number, time.perf_counter())):
                    begin = time.perf_counter()
                    save(number, learning)
                    pace.written(begin, time.perf_counter())
                    saved = number
                if any_process(bool(signals)):
                    raise Terminated if signal.SIGTERM in signals else KeyboardInterrupt
                if any_process(keeping.after_update(number, rows, learning, parameters)):
                    progress.stopped = True
                    break
                last = (
                    time.perf_counter()
                )  # evaluating, saving and callbacks don't count as part of an update
        except OSError:
            whole = None  # there is no room for another attempt
            raise
        except jax.errors.JaxRuntimeError as error:
            if "RESOURCE_EXHAUSTED" in str(error):
                raise NoMemoryError(
                    f"{str(error).splitlines()[0]}; make num_envs, num_steps or seeds smaller, and start again"
                ) from None
            raise
        finally:
            if whole is not None and whole > saved:
                save(whole, _learning(progress, config))
    return state


def of_seed(tree: Any, index: int, config: Config) -> Any:
    """Returns one seed's part of a tree of all seeds."""
    return jax.tree.map(lambda leaf: leaf[index], tree) if config.seeds > 1 else tree


def diverged_before(
    state: TrainState, recorders: Sequence[Recorder], config: Config
) -> dict[int, int]:
    """Returns the seeds of a resumed state that have diverged, with the update in which they did: that of their last row."""
    stopped = np.atleast_1d(jax.device_get(state.diverged))
    numbers = [recorder.history.updates for recorder in recorders] or [0] * config.seeds
    return {
        seed: number
        for seed, number, bad in zip(config.seed_numbers, numbers, stopped, strict=True)
        if bad
    }


def _learning(progress: Progress, config: Config) -> list[int]:
    """Returns the indices of the seeds that haven't diverged."""
    return [
        index for index, seed in enumerate(config.seed_numbers) if seed not in progress.diverged
    ]


def _record(
    rows: Sequence[Row], parameters: Any, progress: Progress, config: Config, keeping: Keeping
) -> list[int]:
    """Writes the rows of the seeds that are learning; returns the indices of those that still are.

    A seed whose loss isn't finite stops alone: its parameters are still those of the update before (`keep_if_finite`), and are stored.

    Raises:
      RunError: none is left.
    """
    before = _learning(progress, config)
    for index, recorder in keeping.recording(before):
        row = rows[index]
        recorder.append(row)
        if not math.isfinite(row["loss"]):
            good = row["update"] - 1
            recorder.store(
                of_seed(jax.device_get(parameters), index, config), good, f"{good:08d}", "last"
            )
    progress.diverged |= {
        config.seed_numbers[index]: rows[index]["update"]
        for index in before
        if not math.isfinite(rows[index]["loss"])
    }
    learning = _learning(progress, config)
    if not learning:
        raise RunError(
            f"{describe_divergence(progress.diverged)}. Try a smaller learning_rate than {config.learning_rate:g}"
        )
    return learning


def _summary(
    rows: Sequence[Row], learning: Sequence[int], keeping: Keeping
) -> tuple[Row, list[str]]:
    """Returns the mean row of the seeds that learn, with `before_learning` of their returns, and the warnings that are due."""
    row = mean_row([rows[index] for index in learning])
    recorders = [recorder for _, recorder in keeping.recording(learning)]
    before = [recorder.history.signs.before_learning for recorder in recorders]
    known = [figure for figure in before if math.isfinite(figure)]
    row["before_learning"] = sum(known) / len(known) if known else math.nan
    nothing: dict[int, Sequence[LearningWarning]] = {
        recorder.seed: () for recorder in keeping.recorders
    }
    due = {
        recorder.seed: recorder.history.warnings
        for recorder in recorders
        if recorder.history.is_judged
    }
    return row, said_once(nothing | due)


def describe_divergence(diverged: Mapping[int, int]) -> str:
    """Returns which seeds diverged when, in words."""
    return "; ".join(
        f"the loss became nan in update {update} of {seeds_in_words(seeds)}; the policy of update {update - 1} is kept"
        for update, seeds in seeds_of_each(diverged.items()).items()
    )


@contextmanager
def noting_signals() -> Iterator[Sequence[int]]:
    """Yields a list that gets the number of each SIGINT (Ctrl-C) and SIGTERM, in place of what they would do.

    An update isn't interrupted, as its state couldn't be saved. A second Ctrl-C interrupts it. Off the main thread nothing is noted.
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
