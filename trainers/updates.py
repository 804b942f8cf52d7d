"""The loop over the updates of a run: metrics, checkpoints and policies, also if the run is interrupted."""

import math
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import jax
import jax.numpy as jnp
import numpy as np

from .checkpoint_pace import CheckpointPace
from .compiled import Compiled, NoMemoryError
from .config import Config
from .environment import Environment
from .metric_rows import flatten_metrics, mean_row
from .metrics_files import Row
from .policies import Policy, trained_policy
from .processes import any_says
from .progress import Show
from .recorder import Recorder
from .run_errors import RunError
from .training_functions import TrainState


@dataclass(frozen=True)
class Update:
    """What a callback is told after an update."""

    number: int  # updates done
    env_steps: int  # of each seed, so far
    row: Row  # the metrics of this update; of several seeds the means
    rows: Mapping[int, Row]  # seed -> its metrics; those that have diverged are left out
    run_dir: Path
    policy_of: Callable[[int], Policy]  # seed -> the policy as it is now

    @property
    def policy(self) -> Policy:
        """The policy as it is now, of the first seed."""
        return self.policy_of(next(iter(self.rows)))


Callback = Callable[[Update], Any]  # what is done after an update; if it returns True, the run ends there


@dataclass
class Progress:
    """How far a run is."""

    updates: int  # done
    diverged: dict[int, int] = field(default_factory=dict)  # seed -> the update in which its loss was not finite
    stopped: bool = False  # by its callback


class Saver(Protocol):
    """What writes checkpoints."""

    def save(self, update: int, state: Any, known: Mapping[str, Any]) -> None:
        """Writes the state after an update. Raises OSError when there is no room."""
        ...


@dataclass(frozen=True)
class Keeping:
    """Where the updates of a run are kept and shown."""

    recorders: Sequence[Recorder]  # of each seed; none in processes that do not write
    checkpoints: Saver
    show: Show
    tell: Callable[[int, Sequence[Row], Sequence[int], Any], bool] = lambda *_: False  # the callback; whether the run is to end
    runs: int = 1  # that are trained side by side by one program, with as many seeds each


def run_updates(compiled: Compiled, state: TrainState, progress: Progress, config: Config, keeping: Keeping) -> TrainState:
    """Runs the updates that are left; whatever stops them, what was done until then is kept.

    Args:
      state: after `progress.updates` updates.
      progress: brought up to date after each.
    Raises:
      RunError: all seeds diverged. NoMemoryError, OSError, KeyboardInterrupt: what stopped the run.
    """
    before = max((recorder.history.seconds for recorder in keeping.recorders), default=0.0)
    began = last = time.perf_counter()
    pace = CheckpointPace(config, state_bytes(state), began)
    saved = progress.updates
    whole: int | None = saved  # the update that `state` is of; None while its memory is lent to a function
    with stop_between_updates() as asked_to_stop:
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
                    "env_steps": number * config.steps_per_update,
                    "seconds": before + now - began,
                    "steps_per_second": config.steps_per_update * config.seeds / keeping.runs / (now - last),
                    "rollout_share": (acted - last) / (now - last),
                }
                rows = [start | flatten_metrics(of_seed(measured, index, config)) for index in range(config.seeds)]
                parameters = compiled.parameters(state)
                learning = _record(rows, parameters, progress, config, keeping)
                progress.updates = number
                _keep_policies(parameters, number, learning, config, keeping)
                whole = number  # with its evaluation, which is not made again
                keeping.show(*_shown(rows, learning, keeping))
                if any_says(pace.is_due(number, time.perf_counter())):
                    pace.written(*_save(state, parameters, number, learning, config, keeping))
                    saved = number
                if any_says(asked_to_stop()):
                    raise KeyboardInterrupt
                if any_says(keeping.tell(number, rows, learning, parameters)):
                    progress.stopped = True
                    break
                last = time.perf_counter()  # what was evaluated, saved and told is no part of an update
        except OSError:
            whole = None  # there is no room for another attempt
            raise
        except jax.errors.JaxRuntimeError as error:
            if "RESOURCE_EXHAUSTED" in str(error):
                raise NoMemoryError(f"{str(error).splitlines()[0]}; make num_envs, num_steps or seeds smaller, and start anew") from None
            raise
        finally:
            if whole is not None and whole > saved:
                _save(state, compiled.parameters(state), whole, _learning(progress, config), config, keeping)
    return state


def make_teller(
    callback: Callback, env: Environment, config: Config, run_dir: Path
) -> Callable[[int, Sequence[Row], Sequence[int], Any], bool]:
    """Returns what tells a callback of an update: of its number, rows, the indices of the seeds that learn, and the parameters."""

    def tell(number: int, rows: Sequence[Row], learning: Sequence[int], parameters: Any) -> bool:
        def policy_of(seed: int) -> Policy:
            own = of_seed(parameters, config.seed_numbers.index(seed), config)
            return trained_policy(env, config, jax.tree.map(jnp.copy, own))  # the next update reuses the memory of these

        known = {config.seed_numbers[index]: rows[index] for index in learning}
        row = mean_row([rows[index] for index in learning])
        return callback(Update(number, row["env_steps"], row, known, run_dir, policy_of)) is True

    return tell


def of_seed(tree: Any, index: int, config: Config) -> Any:
    """Returns one seed's part of a tree that has all seeds'."""
    return jax.tree.map(lambda leaf: leaf[index], tree) if config.seeds > 1 else tree


def state_bytes(state: Any) -> int:
    """Returns how large a state is: what a checkpoint of it writes."""
    return sum(leaf.size * leaf.dtype.itemsize for leaf in jax.tree.leaves(state))


def diverged_before(state: TrainState, recorders: Sequence[Recorder], config: Config) -> dict[int, int]:
    """Returns the seeds of a state that is gone on from which have diverged, with the update in which they did: their last row's."""
    stopped = np.atleast_1d(jax.device_get(state.diverged))
    numbers = [recorder.history.updates for recorder in recorders] or [0] * config.seeds
    return {seed: number for seed, number, bad in zip(config.seed_numbers, numbers, stopped, strict=True) if bad}


def _learning(progress: Progress, config: Config) -> list[int]:
    """Returns the indices of the seeds that have not diverged."""
    return [index for index, seed in enumerate(config.seed_numbers) if seed not in progress.diverged]


def _record(rows: Sequence[Row], parameters: Any, progress: Progress, config: Config, keeping: Keeping) -> list[int]:
    """Writes the rows of the seeds that are learning; returns the indices of those that still are.

    A seed whose loss is not finite stops alone: its parameters are still those of the update before (`keep_if_finite`), and stored.

    Raises:
      RunError: none is left.
    """
    for index in _learning(progress, config):
        row = rows[index]
        for recorder in keeping.recorders[index : index + 1]:
            recorder.append(row)
            if not math.isfinite(row["loss"]):
                recorder.keep_good(of_seed(jax.device_get(parameters), index, config), row["update"] - 1)
        if not math.isfinite(row["loss"]):
            progress.diverged[config.seed_numbers[index]] = row["update"]
    learning = _learning(progress, config)
    if not learning:
        raise RunError(f"{divergence(progress.diverged)}. Try a smaller learning_rate than {config.learning_rate:g}")
    return learning


def _shown(rows: Sequence[Row], learning: Sequence[int], keeping: Keeping) -> tuple[Row, list[str]]:
    """Returns the mean row of the seeds that learn, with `before_learning` of their returns, and the warnings that are due."""
    row = mean_row([rows[index] for index in learning])
    recorders = [recorder for index in learning for recorder in keeping.recorders[index : index + 1]]
    before = [recorder.history.signs.before_learning for recorder in recorders]
    known = [figure for figure in before if math.isfinite(figure)]
    row["before_learning"] = sum(known) / len(known) if known else math.nan
    said = [(recorder.folder, warning) for recorder in recorders if recorder.history.is_judged for warning in recorder.history.warnings]
    return row, [f"{folder}: {warning}" if len(keeping.recorders) > 1 else warning for folder, warning in said]


def divergence(diverged: dict[int, int]) -> str:
    """Returns which seeds diverged when, in words."""
    said = [
        f"the loss became nan in update {update} of seed {seed}; the policy of update {update - 1} is kept"
        for seed, update in diverged.items()
    ]
    return "; ".join(said)


def _keep_policies(parameters: Any, number: int, learning: Sequence[int], config: Config, keeping: Keeping) -> None:
    """Evaluates and stores the policies of an update, where that is due."""
    evaluates = config.evaluate_every and number % config.evaluate_every == 0
    for index in learning:
        for recorder in keeping.recorders[index : index + 1]:
            marks = recorder.history.is_mark(number)
            if not (evaluates or marks):
                continue
            own = of_seed(jax.device_get(parameters), index, config)
            if evaluates:
                recorder.evaluate(own, number)
            if marks:
                recorder.mark(own, number)


def _save(
    state: TrainState, parameters: Any, number: int, learning: Sequence[int], config: Config, keeping: Keeping
) -> tuple[float, float]:
    """Writes a checkpoint and the last policies; metrics first, so that none is missing from a run that goes on.

    Returns when it began and ended.
    """
    began = time.perf_counter()
    local = jax.device_get(parameters)
    for index in learning:
        for recorder in keeping.recorders[index : index + 1]:
            recorder.keep(of_seed(local, index, config), number)
    keeping.checkpoints.save(number, state, {})
    return began, time.perf_counter()


@contextmanager
def stop_between_updates() -> Iterator[Callable[[], bool]]:
    """Yields whether Ctrl-C was pressed: an update is not cut in two, for its state could not be saved. A second one cuts."""
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    pressed = False

    def press(*_: Any) -> None:
        nonlocal pressed
        pressed = True
        signal.signal(signal.SIGINT, before)

    before = signal.signal(signal.SIGINT, press)
    try:
        yield lambda: pressed
    finally:
        signal.signal(signal.SIGINT, before)
