"""Runs a whole training: starts a new folder or resumes one, runs all updates, and returns the trained policies."""

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext, suppress
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from itertools import zip_longest
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp

from .algorithms import make_train
from .compiled import NoMemoryError, compile_train, peak_megabytes, with_spread_starts
from .config import Config, stored_config
from .environment import Environment, episode_length
from .extensions import short_name
from .loggers import LoggerName
from .manifest import MANIFEST
from .metric_rows import mean_row
from .metrics_files import METRICS_JSONL, Row, read_rows
from .policies import Policy, trained_policy
from .policy_file import START, copy_policy
from .processes import any_process, is_first
from .progress import ProgressStyle, show_progress
from .recorder import Recorder, open_recorders
from .resuming import check_same_run, extended
from .run_errors import DiskError, RunError, TooLargeError
from .run_files import write_json
from .run_folder import describe_run
from .run_lock import in_use, is_unused, locked
from .side_by_side import Part, PartCheckpoints, compile_parts, joint_config, kind_of, of_part
from .updates import AfterUpdate, Callback, Keeping, Progress, Update, describe_divergence, diverged_before, of_seed, run_updates

NOT_EMPTY = "{} is not empty; name a new folder, so that no earlier run is lost, or resume the run in it"

__all__ = ["Result", "Run", "RunError", "resume", "train", "train_side_by_side"]


@dataclass(frozen=True)
class Result:
    """A finished run."""

    run_dir: Path
    parameters: Any  # of the networks, after the last update; those of several seeds are stacked
    updates: int
    diverged: Mapping[int, int]  # seed -> the update in which its loss was not finite, while other seeds went on
    folders: tuple[Path, ...]  # of each seed
    compile_seconds: float
    seconds: float  # compiling included
    peak_megabytes: float  # the most memory this process, or the device, held

    @property
    def rows(self) -> tuple[Row, ...]:
        """One row an update, read from metrics.jsonl; with several seeds, the means over those that learnt."""
        seeds = zip_longest(*(read_rows(folder / METRICS_JSONL) for folder in self.folders))
        return tuple(mean_row([row for row in rows if row is not None]) for rows in seeds)


@dataclass(frozen=True)
class Run:
    """A run for `train_side_by_side`; the fields are the arguments of `train`."""

    env: Environment
    config: Config
    run_dir: Path
    provenance: Mapping[str, Any] = field(default_factory=dict)
    loggers: Sequence[LoggerName] = ()
    asked: Mapping[str, Any] = field(default_factory=dict)


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
    """Trains, and writes manifest, metrics, checkpoints, policies and learning curve to `run_dir` along the way.

    Args:
      env: one environment, from `sjdsl.make`.
      config: the run's configuration, seed included.
      run_dir: a new or empty folder.
      progress: `bar` (rich), `lines`, `none`; `auto` is `bar` on a terminal and `lines` elsewhere.
      provenance: JSON values for the manifest, such as the arguments that made `env`.
      loggers: where metrics go as well: `tensorboard`, `wandb`.
      asked: further JSON values for the manifest, for when the run is resumed.
      callback: called with an `Update` after each update, in the first of several processes; the run ends there if it returns True.
    Raises:
      RunError: the folder isn't empty, or another process trains there; every seed diverged; or the disk or the memory is full. What was
        written before stays.
      ConfigError: the configuration doesn't fit the environment. PolicyError: a policy that it names can't be read.
    """
    run_dir = Path(run_dir)
    if any_process(not is_unused(run_dir)):
        raise RunError(NOT_EMPTY.format(run_dir))
    make_train(env, config)  # fails before the folder is made if something doesn't fit
    with _lock(run_dir):
        if is_first() and not is_unused(run_dir):  # another process was faster
            raise RunError(NOT_EMPTY.format(run_dir))
        return _run((_start(Run(env, config, run_dir, provenance or {}, loggers, asked or {})),), progress, callback)[0]


def resume(
    env: Environment,
    run_dir: Path | str,
    progress: ProgressStyle = "auto",
    loggers: Sequence[LoggerName] | None = None,
    asked: Mapping[str, Any] | None = None,
    callback: Callback | None = None,
    total_timesteps: int | None = None,
) -> Result:
    """Resumes a run from its last checkpoint; on a CPU it ends with the metrics of a run that was never stopped.

    Args:
      env: made as the run's manifest says.
      run_dir: the folder of a run that was stopped, in whatever way.
      progress, loggers, asked, callback: as in `train`; loggers and `asked` stay those of the run unless given.
      total_timesteps: makes the run longer, even a finished one. From there on, schedules over the whole run (of the learning rate, for
        example) are those of the longer run.
    Raises:
      RunError: there is no such run, or another process trains in its folder; it was of another game or other versions, or has done more
        steps already; or rows of its metrics are lost.
    """
    run_dir = Path(run_dir)
    check_same_run(env, run_dir)
    with _lock(run_dir):
        manifest = check_same_run(env, run_dir)  # again, now that no other process writes it
        if total_timesteps is not None:
            manifest = extended(manifest, run_dir, total_timesteps)
        manifest = mark_resumed(manifest)
        manifest |= {"loggers": list(manifest.get("loggers", ()) if loggers is None else loggers)}
        manifest |= {"asked": manifest.get("asked", {}) | dict(asked or {})}
        return _run((Part(env, stored_config(manifest["config"]), run_dir, manifest),), progress, callback)[0]


def train_side_by_side(runs: Sequence[Run], progress: ProgressStyle = "auto", callback: Callback | None = None) -> tuple[Result, ...]:
    """Trains runs that differ only in numbers without shape as one program, and writes each run's folder as `train` would.

    A folder that holds the run already, stopped, is resumed. Figures are those of runs trained alone but for rounding: programs that are
    compiled separately don't add in the same order.

    Args:
      runs: of one kind (`side_by_side.kind_of`), with a checkpoint of the same update, or without any.
      progress: as in `train`.
      callback: called with an `Update` of each run after each update; all runs end if it returns True for one.
    Raises:
      RunError: as `train`; or another process trains in one of the folders; every seed of every run diverged; the runs can't be trained
        as one program.
    """
    if len({kind_of(run.env, run.config) for run in runs}) != 1:
        raise RunError("runs that are trained side by side may differ only in seeds and in numbers without shape")
    for run in runs:
        make_train(run.env, run.config)  # fails before a folder is made if something doesn't fit
    with ExitStack() as stack:
        parts = []
        for run in runs:
            stack.enter_context(_lock(run.run_dir))
            if (run.run_dir / MANIFEST).is_file():
                parts.append(Part(run.env, run.config, run.run_dir, mark_resumed(check_same_run(run.env, run.run_dir))))
            else:
                parts.append(_start(run))
        return _run(parts, progress, callback)


def _lock(run_dir: Path) -> AbstractContextManager[None]:
    """Returns the lock of a run's folder, in the process that writes there."""
    return locked(run_dir, in_use(run_dir)) if is_first() else nullcontext()


def _start(run: Run) -> Part:
    """Returns a run that starts in a new or empty folder."""
    run.run_dir.mkdir(parents=True, exist_ok=True)
    if run.config.init_from and is_first():
        copy_policy(run.config.init_from, run.run_dir / START)
    manifest = describe_run(run.env, run.config, run.provenance) | {"loggers": list(run.loggers), "asked": dict(run.asked)}
    return Part(run.env, run.config, run.run_dir, manifest)


def mark_resumed(manifest: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the manifest of a run that is resumed now."""
    resumed = [*manifest.get("resumed", []), datetime.now(UTC).isoformat(timespec="seconds")]
    return {**manifest, "status": "running", "resumed": resumed}


def _run(parts: Sequence[Part], progress: ProgressStyle, callback: Callback | None) -> tuple[Result, ...]:
    """Runs the remaining updates of one run, or of several side by side."""
    began = time.perf_counter()
    config = joint_config(parts)
    titles = [f"{part.env.name}, {short_name(part.config.algorithm)}, {short_name(part.config.reward)} reward" for part in parts]
    together = f", and {len(parts) - 1} more side by side" if len(parts) > 1 else ""
    with ExitStack() as stack:
        for part in parts:
            stack.enter_context(recording_status(part.run_dir, part.manifest))
        style = progress if is_first() else "none"
        show = stack.enter_context(show_progress(style, config.num_updates, titles[0] + together, config.seeds))
        starts = [_from_own_start(part) for part in parts]
        if len(parts) > 1:
            for part in parts:
                part.manifest["together"] = len(parts)
            compiled = compile_parts(starts)
        else:
            compiled = compile_train(make_train(starts[0].env, starts[0].config), config)
        compiled = with_spread_starts(compiled, config, max(episode_length(part.env) for part in parts))
        checkpoints = PartCheckpoints(parts)
        stack.callback(checkpoints.close)
        state, done = checkpoints.restore_last(compiled)
        each: list[list[Recorder]] = []
        for part, title in zip(parts, titles, strict=True):
            part.manifest.update(compile_seconds=compiled.seconds, program_megabytes=compiled.megabytes)
            opened = open_recorders(part.folders, part.env, part.config, done, part.manifest["loggers"], title)
            each.append(stack.enter_context(opened))
        recorders = [recorder for own in each for recorder in own]
        so_far = Progress(done, diverged_before(state, recorders, config))
        try:
            keeping = Keeping(recorders, checkpoints.save, show, runs=len(parts))
            if callback is not None and is_first():
                keeping = replace(keeping, after_update=_call_after_update(callback, parts, config))
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
            diverged = diverged_of(index, parts, so_far)
            if len(diverged) == part.config.seeds:  # other runs went on
                part.manifest["status"] = f"failed: {describe_divergence(diverged)}"
            elif so_far.stopped:
                part.manifest["status"] = f"stopped by its callback after update {so_far.updates}"
        parameters = jax.device_get(compiled.parameters(state))
    times = (compiled.seconds, time.perf_counter() - began, peak_megabytes())
    return tuple(
        Result(part.run_dir, of_part(parameters, index, parts), so_far.updates, diverged_of(index, parts, so_far), part.folders, *times)
        for index, part in enumerate(parts)
    )


def _from_own_start(part: Part) -> Part:
    """Returns a run that starts from its own copy of the policy it began with, which may be gone from its old place."""
    start = part.run_dir / START
    return replace(part, config=part.config.model_copy(update={"init_from": str(start)})) if start.is_file() else part


def _call_after_update(callback: Callback, parts: Sequence[Part], config: Config) -> AfterUpdate:
    """Returns a function that calls the callback once for each run that still has a seed that learns. config: of all parts together."""

    def after_update(number: int, rows: Sequence[Row], learning: Sequence[int], parameters: Any) -> bool:
        ends = []
        for index, part in enumerate(parts):
            lanes = {seed: index * part.config.seeds + place for place, seed in enumerate(part.config.seed_numbers)}

            def policy_of(seed: int, part: Part = part, lanes: Mapping[int, int] = lanes) -> Policy:
                own = of_seed(parameters, lanes[seed], config)
                return trained_policy(part.env, part.config, jax.tree.map(jnp.copy, own))  # the next update reuses their memory

            known = {seed: rows[lane] for seed, lane in lanes.items() if lane in learning}
            if known:
                row = mean_row([*known.values()])
                ends.append(callback(Update(number, row["env_steps"], row, known, part.run_dir, policy_of)) is True)
        return any(ends)

    return after_update


def diverged_of(index: int, parts: Sequence[Part], so_far: Progress) -> dict[int, int]:
    """Returns the seeds of a part that have diverged, with the update in which they did."""
    config = parts[index].config
    lanes = config.seed_numbers if len(parts) == 1 else range(index * config.seeds, (index + 1) * config.seeds)
    return {seed: so_far.diverged[lane] for seed, lane in zip(config.seed_numbers, lanes, strict=True) if lane in so_far.diverged}


@contextmanager
def recording_status(run_dir: Path, manifest: dict[str, Any]) -> Iterator[None]:
    """Writes the manifest at the start, and again with how the run ended; turns faults of memory and disk into RunErrors."""
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
            raise DiskError(_disk_message(error, run_dir)) from error
        raise
    finally:
        if is_first():
            with suppress(OSError):  # a full disk leaves the manifest from the start
                write_json(run_dir / MANIFEST, manifest)


def _disk_message(error: OSError, run_dir: Path) -> str:
    """Returns the message about a disk; of several errors, about the first, as a full disk also fails what is tried afterwards."""
    faults: list[OSError] = []
    fault: BaseException | None = error
    while fault is not None:
        faults += [fault] if isinstance(fault, OSError) else []
        fault = fault.__context__
    first = next((fault for fault in reversed(faults) if fault.filename), faults[-1])
    where = first.filename or run_dir
    return f"{where} could not be written: {first.strerror or first}. What was saved before is whole: make room, and resume {run_dir}"
