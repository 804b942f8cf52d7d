"""A training run: from a fresh folder, or from where it was stopped, to trained policies."""

import math
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import jax

from .checkpoints import Checkpoints
from .compiled import Compiled, NoMemoryError, compile_train, peak_megabytes
from .config import Config, make_config
from .environment import Environment
from .loggers import LoggerName
from .processes import any_says, is_first
from .program import TrainState, make_train
from .progress import ProgressStyle, show_progress
from .recorder import Recorder, open_recorders
from .resuming import RunError, check_same_run, restore_last
from .rows import flatten_metrics, mean_row
from .run_files import write_json
from .run_folder import MANIFEST, Row, Show, describe_run, seed_folders

__all__ = ["Result", "RunError", "resume", "train"]


@dataclass(frozen=True)
class Result:
    """A finished run."""

    run_dir: Path
    parameters: Any  # of the networks, after the last update; of several seeds stacked
    rows: tuple[Row, ...]  # one per update, as in metrics.jsonl; of several seeds their means
    compile_seconds: float
    seconds: float  # compiling included
    peak_megabytes: float  # the most memory this process, or the device, held


def train(
    env: Environment,
    config: Config,
    run_dir: Path | str,
    progress: ProgressStyle = "auto",
    provenance: Mapping[str, Any] | None = None,
    loggers: Sequence[LoggerName] = (),
) -> Result:
    """Trains and writes manifest, metrics, checkpoints, policies and learning curve to `run_dir` as it goes.

    Args:
      env: one environment, from `sjdsl.make`.
      config: the run's configuration, seed included.
      run_dir: a new or empty folder.
      progress: `bar` (rich), `lines`, `none`; `auto` is `bar` on a terminal and `lines` elsewhere.
      provenance: JSON values kept in the manifest, such as the arguments `env` was made with.
      loggers: where metrics go besides: `tensorboard`, `wandb`.
    Raises:
      RunError: the folder is in use, training diverged, or the disk or the memory is full; what was written until then stays.
      ConfigError: the configuration does not fit the environment.
    """
    run_dir = Path(run_dir)
    if any_says(run_dir.exists() and (not run_dir.is_dir() or any(run_dir.iterdir()))):
        raise RunError(f"{run_dir} is not empty; name a new folder, so that no earlier run is lost, or resume the run in it")
    make_train(env, config)  # what does not fit is said before the folder is made
    run_dir.mkdir(parents=True, exist_ok=True)
    return _run(env, config, run_dir, progress, describe_run(env, config, provenance or {}), loggers)


def resume(env: Environment, run_dir: Path | str, progress: ProgressStyle = "auto", loggers: Sequence[LoggerName] = ()) -> Result:
    """Goes on with a run from its last checkpoint; on a CPU it ends with the metrics of a run that was never stopped.

    Args:
      env: made as the run's manifest says.
      run_dir: the folder of a run that was stopped, by whatever.
      progress, loggers: as in `train`.
    Raises:
      RunError: no such run, or it was of another game or of other versions.
    """
    run_dir = Path(run_dir)
    manifest = check_same_run(env, run_dir)
    manifest |= {"status": "running", "resumed": [*manifest.get("resumed", []), datetime.now(UTC).isoformat(timespec="seconds")]}
    return _run(env, make_config(manifest["config"]), run_dir, progress, manifest, loggers)


def _run(
    env: Environment,
    config: Config,
    run_dir: Path,
    progress: ProgressStyle,
    manifest: dict[str, Any],
    loggers: Sequence[LoggerName],
) -> Result:
    began = time.perf_counter()
    title = f"{env.name}, {config.algorithm}, {config.reward} reward"
    with ExitStack() as stack:
        stack.enter_context(_told(run_dir, manifest))
        show = stack.enter_context(show_progress(progress if is_first() else "none", config.num_updates, title))
        compiled = compile_train(make_train(env, config), config)
        manifest |= {"compile_seconds": compiled.seconds, "program_megabytes": compiled.megabytes}
        checkpoints = Checkpoints(run_dir)
        stack.callback(checkpoints.close)
        state, done = restore_last(checkpoints, compiled)
        folders = seed_folders(run_dir, config)
        recorders = stack.enter_context(open_recorders(folders, env, config, done, loggers, title))
        try:
            state = _run_updates(compiled, state, done, config, recorders, checkpoints, show)
        finally:
            rows = [mean_row(rows) for rows in zip(*(recorder.rows for recorder in recorders), strict=False)]
            manifest |= {
                "updates": len(rows),
                "seconds": time.perf_counter() - began,
                "peak_megabytes": peak_megabytes(),
            }
        parameters = jax.device_get(compiled.parameters(state))
    return Result(run_dir, parameters, tuple(rows), compiled.seconds, time.perf_counter() - began, peak_megabytes())


def _run_updates(
    compiled: Compiled,
    state: TrainState,
    done: int,
    config: Config,
    recorders: Sequence[Recorder],
    checkpoints: Checkpoints,
    show: Show,
) -> TrainState:
    """Runs the updates that are left; whatever stops them, what was done until then is kept."""
    before = recorders[0].rows[-1]["seconds"] if recorders and recorders[0].rows else 0.0
    began = last = time.perf_counter()
    saved = done
    whole: int | None = done  # the update that `state` is of; None while its memory is lent to a function
    with stop_between_updates() as asked_to_stop:
        try:
            for number in range(done + 1, config.num_updates + 1):
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
                    "steps_per_second": config.steps_per_update * config.seeds / (now - last),
                    "rollout_share": (acted - last) / (now - last),
                }
                rows = [start | flatten_metrics(of_seed(measured, index, config)) for index in range(config.seeds)]
                for recorder, row in zip(recorders, rows, strict=False):
                    recorder.append(row)
                parameters = compiled.parameters(state)
                _check_finite(rows, recorders, parameters, config)
                whole = number
                show(mean_row(rows))
                if config.evaluate_every and number % config.evaluate_every == 0:
                    for index, recorder in enumerate(recorders):
                        recorder.evaluate(of_seed(jax.device_get(parameters), index, config), number)
                if config.checkpoint_every and number % config.checkpoint_every == 0:
                    _save(checkpoints, recorders, state, parameters, number, config)
                    saved = number
                last = time.perf_counter()  # what was evaluated and saved is no part of an update
                if any_says(asked_to_stop()):
                    raise KeyboardInterrupt
        except OSError:
            whole = None  # there is no room for another attempt
            raise
        except jax.errors.JaxRuntimeError as error:
            if "RESOURCE_EXHAUSTED" in str(error):
                raise NoMemoryError(f"{str(error).splitlines()[0]}; make num_envs, num_steps or seeds smaller, and start anew") from None
            raise
        finally:
            if whole is not None and whole > saved:
                _save(checkpoints, recorders, state, compiled.parameters(state), whole, config)
    return state


def of_seed(tree: Any, index: int, config: Config) -> Any:
    """Returns one seed's part of a tree that has all seeds'."""
    return jax.tree.map(lambda leaf: leaf[index], tree) if config.seeds > 1 else tree


def _save(checkpoints: Checkpoints, recorders: Sequence[Recorder], state: TrainState, parameters: Any, number: int, config: Config) -> None:
    """Writes a checkpoint and the policies of an update; metrics first, so that none is missing from a run that goes on."""
    local = jax.device_get(parameters)
    for index, recorder in enumerate(recorders):
        recorder.keep(of_seed(local, index, config), number)
    checkpoints.save(number, state, {})


def _check_finite(rows: Sequence[Row], recorders: Sequence[Recorder], parameters: Any, config: Config) -> None:
    """Raises RunError when the loss of a seed is not finite; its parameters are still those before (`keep_if_finite`), and stored."""
    for index, (seed, row) in enumerate(zip(config.seed_numbers, rows, strict=True)):
        if not math.isfinite(row["loss"]):
            good = row["update"] - 1
            for recorder in recorders[index : index + 1]:
                recorder.keep(of_seed(jax.device_get(parameters), index, config), good)
            raise RunError(
                f"the loss became {row['loss']} in update {row['update']} of seed {seed}; the policy of update {good} is kept. "
                f"Try a smaller learning_rate than {config.learning_rate:g}"
            )


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


@contextmanager
def _told(run_dir: Path, manifest: dict[str, Any]) -> Iterator[None]:
    """Writes the manifest at the start, and again with how the run ended; makes faults of memory and disk RunErrors."""
    if is_first():
        write_json(run_dir / MANIFEST, manifest)
    try:
        yield
        manifest["status"] = "finished"
    except KeyboardInterrupt:
        manifest["status"] = "interrupted"
        raise
    except BaseException as error:
        manifest["status"] = f"failed: {error}"
        if isinstance(error, NoMemoryError):
            raise RunError(str(error)) from None
        if isinstance(error, OSError):
            raise RunError(_of_disk(error, run_dir)) from error
        raise
    finally:
        if is_first():
            _write_if_room(run_dir / MANIFEST, manifest)


def _of_disk(error: OSError, run_dir: Path) -> str:
    faults: list[OSError] = []
    fault: BaseException | None = error
    while fault is not None:
        faults += [fault] if isinstance(fault, OSError) else []
        fault = fault.__context__
    first = next((fault for fault in reversed(faults) if fault.filename), faults[-1])  # that no curve can be drawn either is no news
    where = first.filename or run_dir
    return f"{where} could not be written: {first.strerror or first}. What was saved before is whole: make room, and resume {run_dir}"


def _write_if_room(path: Path, manifest: Mapping[str, Any]) -> None:
    """Writes the manifest; a disk that is full leaves the one that was written at the start."""
    try:
        write_json(path, manifest)
    except OSError:
        path.with_name(path.name + ".unfinished").unlink(missing_ok=True)
