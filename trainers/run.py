"""Runs a whole training: starts a new folder or resumes one, runs all updates, and returns the trained policies."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext, suppress
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from itertools import zip_longest
from pathlib import Path
from typing import Any

import jax

from .algorithms import make_train
from .checkpoints import Checkpoints
from .compiled import Compiled, NoMemoryError, compile_train, peak_megabytes, with_spread_starts
from .config import Config, stored_config
from .environment import Environment, episode_length
from .extensions import short_name
from .loggers import LoggerName
from .manifest import MANIFEST
from .metric_rows import mean_row
from .metrics_files import METRICS_JSONL, Row, read_rows
from .policy_file import START, copy_policy
from .processes import any_says, is_first
from .progress import ProgressStyle, show_progress
from .recorder import Recorder, open_recorders
from .resuming import check_same_run, extended, restore_last
from .run_errors import DiskError, RunError, TooLargeError
from .run_files import write_json
from .run_folder import describe_run
from .run_lock import is_unused, locked
from .side_by_side import CheckpointsOfParts, Part, compile_parts, joint_config, kind_of, of_part
from .training_functions import TrainState
from .updates import Callback, Keeping, Progress, Saver, diverged_before, divergence, make_teller, run_updates

NOT_EMPTY = "{} is not empty; name a new folder, so that no earlier run is lost, or resume the run in it"

__all__ = ["Result", "Run", "RunError", "resume", "train", "train_side_by_side"]


@dataclass(frozen=True)
class Result:
    """A finished run."""

    run_dir: Path
    parameters: Any  # of the networks, after the last update; of several seeds stacked
    updates: int
    diverged: Mapping[int, int]  # seed -> the update in which its loss was not finite, where another seed went on
    folders: tuple[Path, ...]  # of each seed
    compile_seconds: float
    seconds: float  # compiling included
    peak_megabytes: float  # the most memory this process, or the device, held

    @property
    def rows(self) -> tuple[Row, ...]:
        """One row an update, as in metrics.jsonl, where they are read from; of several seeds the means of those that learnt."""
        seeds = zip_longest(*(read_rows(folder / METRICS_JSONL) for folder in self.folders))
        return tuple(mean_row([row for row in rows if row is not None]) for rows in seeds)


def train(
    env: Environment,
    config: Config,
    run_dir: Path | str,
    progress: ProgressStyle = "auto",
    provenance: Mapping[str, Any] | None = None,
    loggers: Sequence[LoggerName] = (),
    asked: Mapping[str, Any] | None = None,
    callback: Callback | None = None,
) -> Result:
    """Trains and writes manifest, metrics, checkpoints, policies and learning curve to `run_dir` as it goes.

    Args:
      env: one environment, from `sjdsl.make`.
      config: the run's configuration, seed included.
      run_dir: a new or empty folder.
      progress: `bar` (rich), `lines`, `none`; `auto` is `bar` on a terminal and `lines` elsewhere.
      provenance: JSON values kept in the manifest, such as the arguments `env` was made with.
      loggers: where metrics go besides: `tensorboard`, `wandb`.
      asked: further JSON values kept in the manifest, for whoever resumes the run.
      callback: called with an `Update` after each update, in the first of several processes; the run ends there if it returns True.
    Raises:
      RunError: the folder is not empty, or another process trains there, training diverged with every seed, or the disk or the memory is full; what was written until then stays.
      ConfigError: the configuration does not fit the environment. PolicyError: a policy that it names cannot be read.
    """
    run_dir = Path(run_dir)
    if any_says(not is_unused(run_dir)):
        raise RunError(NOT_EMPTY.format(run_dir))
    make_train(env, config)  # what does not fit is said before the folder is made
    with _held(run_dir):
        if is_first() and not is_unused(run_dir):  # another process was faster
            raise RunError(NOT_EMPTY.format(run_dir))
        return _run((_new(env, config, run_dir, provenance, loggers, asked),), progress, callback)[0]


def _held(run_dir: Path) -> AbstractContextManager[None]:
    """Returns what holds the folder of a run, in the process that writes there."""
    return locked(run_dir) if is_first() else nullcontext()


def _new(
    env: Environment,
    config: Config,
    run_dir: Path,
    provenance: Mapping[str, Any] | None,
    loggers: Sequence[LoggerName],
    asked: Mapping[str, Any] | None,
) -> Part:
    """Returns a run that starts in a new or empty folder."""
    run_dir.mkdir(parents=True, exist_ok=True)
    if config.init_from and is_first():
        copy_policy(config.init_from, run_dir / START)
    manifest = describe_run(env, config, provenance or {}) | {"loggers": list(loggers), "asked": dict(asked or {})}
    return Part(env, config, run_dir, manifest)


def resume(
    env: Environment,
    run_dir: Path | str,
    progress: ProgressStyle = "auto",
    loggers: Sequence[LoggerName] | None = None,
    asked: Mapping[str, Any] | None = None,
    callback: Callback | None = None,
    total_timesteps: int | None = None,
) -> Result:
    """Goes on with a run from its last checkpoint; on a CPU it ends with the metrics of a run that was never stopped.

    Args:
      env: made as the run's manifest says.
      run_dir: the folder of a run that was stopped, by whatever.
      progress, loggers, asked, callback: as in `train`; loggers and what was asked stay those of the run unless they are given.
      total_timesteps: makes the run longer, also a finished one. Schedules over the whole run, as of the learning rate, are from there
        on those of the longer run.
    Raises:
      RunError: no such run, or another process trains in its folder; it was of another game or of other versions, or has done more steps
        already; rows of its metrics are lost.
    """
    run_dir = Path(run_dir)
    check_same_run(env, run_dir)
    with _held(run_dir):
        manifest = check_same_run(env, run_dir)  # again, now that no other process writes it
        if total_timesteps is not None:
            manifest = extended(manifest, run_dir, total_timesteps)
        manifest = _gone_on(manifest)
        manifest |= {"loggers": list(manifest.get("loggers", ()) if loggers is None else loggers)}
        manifest |= {"asked": manifest.get("asked", {}) | dict(asked or {})}
        return _run((Part(env, stored_config(manifest["config"]), run_dir, manifest),), progress, callback)[0]


@dataclass(frozen=True)
class Run:
    """What `train_side_by_side` is to train; the fields are the arguments of `train`."""

    env: Environment
    config: Config
    run_dir: Path
    provenance: Mapping[str, Any] = field(default_factory=dict)
    loggers: Sequence[LoggerName] = ()
    asked: Mapping[str, Any] = field(default_factory=dict)


def train_side_by_side(runs: Sequence[Run], progress: ProgressStyle = "auto", callback: Callback | None = None) -> tuple[Result, ...]:
    """Trains runs that differ in numbers without shape as one program, and writes the folder of each as `train` would.

    A folder that holds the run already, stopped, is gone on with. Figures are those of runs trained apart but for rounding: programs
    that are compiled apart do not add up in the same order.

    Args:
      runs: of one kind (`side_by_side.kind_of`), none of them further than its last checkpoint but one from the others.
      progress: as in `train`.
      callback: called with an `Update` of each run after each update; all end there if it returns True for one.
    Raises:
      RunError: as `train`, or another process trains in one of the folders; every seed of every run has diverged; runs that cannot be trained as one program.
    """
    if len({kind_of(run.env, run.config) for run in runs}) != 1:
        raise RunError("runs that are trained side by side may differ in seeds and in numbers without shape only")
    for run in runs:
        make_train(run.env, run.config)  # what does not fit is said before a folder is made
    with ExitStack() as stack:
        parts = []
        for run in runs:
            stack.enter_context(_held(run.run_dir))
            if (run.run_dir / MANIFEST).is_file():
                manifest = _gone_on(check_same_run(run.env, run.run_dir))
                parts.append(Part(run.env, run.config, run.run_dir, manifest))
            else:
                parts.append(_new(run.env, run.config, run.run_dir, run.provenance, run.loggers, run.asked))
        return _run(parts, progress, callback)


def _gone_on(manifest: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the manifest of a run that is gone on with now."""
    resumed = [*manifest.get("resumed", []), datetime.now(UTC).isoformat(timespec="seconds")]
    return {**manifest, "status": "running", "resumed": resumed}


def _run(parts: Sequence[Part], progress: ProgressStyle, callback: Callback | None) -> tuple[Result, ...]:
    """Runs the updates that are left of one run, or of several side by side."""
    began = time.perf_counter()
    config = joint_config(parts)
    title = _title(parts[0]) + (f", and {len(parts) - 1} more side by side" if len(parts) > 1 else "")
    with ExitStack() as stack:
        for part in parts:
            stack.enter_context(_told(part.run_dir, part.manifest))
        show = stack.enter_context(show_progress(progress if is_first() else "none", config.num_updates, title, config.seeds))
        compiled, checkpoints, (state, done) = _prepared(parts, stack)
        recorders: list[Recorder] = []
        for part in parts:
            part.manifest.update(compile_seconds=compiled.seconds, program_megabytes=compiled.megabytes)
            recorders += stack.enter_context(
                open_recorders(part.folders, part.env, part.config, done, part.manifest["loggers"], _title(part))
            )
        so_far = Progress(done, diverged_before(state, recorders, config))
        each = [recorders[index * part.config.seeds : (index + 1) * part.config.seeds] for index, part in enumerate(parts)]
        try:
            keeping = Keeping(recorders, checkpoints, show, runs=len(parts))
            if callback is not None and is_first():
                keeping = replace(keeping, tell=_teller(callback, parts))
            state = run_updates(compiled, state, so_far, config, keeping)
        finally:
            for index, part in enumerate(parts):
                part.manifest.update(
                    updates=so_far.updates,
                    warnings=sorted({warning for recorder in each[index] for warning in recorder.history.warnings}),
                    diverged=[{"seed": seed, "update": update} for seed, update in diverged_of(index, parts, so_far).items()],
                    seconds=time.perf_counter() - began,
                    peak_megabytes=peak_megabytes(),
                )
        for index, part in enumerate(parts):
            stopped = diverged_of(index, parts, so_far)
            if len(stopped) == part.config.seeds:  # others went on
                part.manifest["status"] = f"failed: {divergence(stopped)}"
            elif so_far.stopped:
                part.manifest["status"] = f"stopped by its callback after update {so_far.updates}"
        parameters = jax.device_get(compiled.parameters(state))
    times = (compiled.seconds, time.perf_counter() - began, peak_megabytes())
    return tuple(
        Result(part.run_dir, of_part(parameters, index, parts), so_far.updates, diverged_of(index, parts, so_far), part.folders, *times)
        for index, part in enumerate(parts)
    )


def _title(part: Part) -> str:
    return f"{part.env.name}, {short_name(part.config.algorithm)}, {short_name(part.config.reward)} reward"


def _prepared(parts: Sequence[Part], stack: ExitStack) -> tuple[Compiled, Saver, tuple[TrainState, int]]:
    """Returns the compiled program, its checkpoints, and the state to go on from with the updates done."""
    if len(parts) > 1:
        for part in parts:
            part.manifest["together"] = len(parts)
        compiled, all_of_them = compile_parts([_from_own_start(part) for part in parts]), CheckpointsOfParts(parts)
        compiled = with_spread_starts(compiled, joint_config(parts), max(episode_length(part.env) for part in parts))
        stack.callback(all_of_them.close)
        return compiled, all_of_them, all_of_them.restore_last(compiled)
    (part,) = parts
    compiled = compile_train(make_train(part.env, _from_own_start(part).config), part.config)
    compiled = with_spread_starts(compiled, part.config, episode_length(part.env))
    checkpoints = Checkpoints(part.run_dir)
    stack.callback(checkpoints.close)
    return compiled, checkpoints, restore_last(checkpoints, compiled)


def _from_own_start(part: Part) -> Part:
    """Returns a run that starts from the copy in its folder of the policy it began with, which may be gone where it was."""
    start = part.run_dir / START
    return replace(part, config=part.config.model_copy(update={"init_from": str(start)})) if start.is_file() else part


def _teller(callback: Callback, parts: Sequence[Part]) -> Callable[[int, Sequence[Row], Sequence[int], Any], bool]:
    """Returns what tells a callback of an update, run by run; of those that have a seed that learns."""
    tellers = [make_teller(callback, part.env, part.config, part.run_dir) for part in parts]

    def tell(number: int, rows: Sequence[Row], learning: Sequence[int], parameters: Any) -> bool:
        ends = []
        for index, (part, teller) in enumerate(zip(parts, tellers, strict=True)):
            first, seeds = index * part.config.seeds, part.config.seeds
            own = [lane - first for lane in learning if first <= lane < first + seeds]
            if own:
                ends.append(teller(number, rows[first : first + seeds], own, of_part(parameters, index, parts)))
        return any(ends)

    return tell


def diverged_of(index: int, parts: Sequence[Part], so_far: Progress) -> dict[int, int]:
    """Returns the seeds of a part that have diverged, with the update in which they did."""
    config = parts[index].config
    lanes = config.seed_numbers if len(parts) == 1 else range(index * config.seeds, (index + 1) * config.seeds)
    return {seed: so_far.diverged[lane] for seed, lane in zip(config.seed_numbers, lanes, strict=True) if lane in so_far.diverged}


@contextmanager
def _told(run_dir: Path, manifest: dict[str, Any]) -> Iterator[None]:
    """Writes the manifest at the start, and again with how the run ended; makes faults of memory and disk RunErrors."""
    if is_first():
        write_json(run_dir / MANIFEST, manifest)
    try:
        yield
        if manifest["status"] == "running":
            manifest["status"] = "finished"
    except KeyboardInterrupt:
        manifest["status"] = "interrupted"
        raise
    except BaseException as error:
        manifest["status"] = f"failed: {error}"
        if isinstance(error, NoMemoryError):
            raise TooLargeError(str(error)) from None
        if isinstance(error, OSError):
            raise DiskError(_of_disk(error, run_dir)) from error
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
    with suppress(OSError):
        write_json(path, manifest)
