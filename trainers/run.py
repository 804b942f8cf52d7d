"""Runs a whole training: starts a new folder or resumes one, runs all updates, and returns the trained policies."""

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext, suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from itertools import zip_longest
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp

from sjdsl.several import several
from sjdsl.termination import raising_on_sigterm

from .algorithms import make_train
from .checkpoints import Checkpoints, resumption
from .compiled import NoMemoryError, compile_train, peak_megabytes, with_spread_starts
from .config import Config, stored_config
from .environment import Environment, episode_length
from .extensions import short_name
from .learning_signs import said_once
from .loggers import LoggerName
from .manifest import MANIFEST
from .metric_rows import mean_row
from .metrics_files import METRICS_JSONL, Row, read_rows
from .policies import Policy, trained_policy
from .policy_file import START, copy_policy
from .processes import any_process, is_first
from .progress import ProgressStyle, show_progress
from .recorder import open_recorders
from .resuming import check_same_run, extended
from .run_errors import DiskError, RunError
from .run_files import write_json
from .run_folder import describe_run, seed_folders
from .run_lock import is_unused, locked
from .updates import AfterUpdate, Callback, Keeping, Progress, Update, diverged_before, of_seed, run_updates

NOT_EMPTY = "{} is not empty; name a new folder, so that no earlier run is lost, or resume the run in it"

__all__ = ["Result", "RunError", "resume", "train"]


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


def train(
    env: Environment,
    config: Config,
    run_dir: Path | str,
    progress: ProgressStyle = "auto",
    provenance: Mapping[str, Any] | None = None,
    loggers: LoggerName | Sequence[LoggerName] = (),
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
      loggers: where metrics go as well: `tensorboard`, `wandb`, or both.
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
        run_dir.mkdir(parents=True, exist_ok=True)
        if config.init_from and is_first():
            copy_policy(config.init_from, run_dir / START)
        manifest = describe_run(env, config, provenance or {}) | {"loggers": list(several(loggers)), "asked": dict(asked or {})}
        return _run(env, config, run_dir, manifest, progress, callback)


def resume(
    env: Environment,
    run_dir: Path | str,
    progress: ProgressStyle = "auto",
    loggers: LoggerName | Sequence[LoggerName] | None = None,
    asked: Mapping[str, Any] | None = None,
    callback: Callback | None = None,
    total_timesteps: int | None = None,
    provenance: Mapping[str, Any] | None = None,
) -> Result:
    """Resumes a run from its last checkpoint; on a CPU it ends with the metrics of a run that was never stopped.

    Args:
      env: made as the run's manifest says.
      run_dir: the folder of a run that was stopped, in whatever way.
      progress, loggers, asked, callback: as in `train`; loggers and `asked` stay those of the run unless given.
      total_timesteps: makes the run longer, even a finished one. From there on, schedules over the whole run (of the learning rate, for
        example) are those of the longer run.
      provenance: how `env` was made, where the run's game has moved.
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
        resumed = [*manifest.get("resumed", []), datetime.now(UTC).isoformat(timespec="seconds")]
        manifest |= {"status": "running", "resumed": resumed}
        manifest |= {"loggers": list(manifest.get("loggers", ()) if loggers is None else several(loggers))}
        manifest |= {"asked": manifest.get("asked", {}) | dict(asked or {})}
        manifest |= {"provenance": dict(manifest.get("provenance", {}) if provenance is None else provenance)}
        return _run(env, stored_config(manifest["config"]), run_dir, manifest, progress, callback)


def _lock(run_dir: Path) -> AbstractContextManager[None]:
    """Returns the lock of a run's folder, in the process that writes there."""
    return locked(run_dir) if is_first() else nullcontext()


@raising_on_sigterm()
def _run(
    env: Environment, config: Config, run_dir: Path, manifest: dict[str, Any], progress: ProgressStyle, callback: Callback | None
) -> Result:
    """Runs the remaining updates; `manifest` is updated as the run goes on."""
    began = time.perf_counter()
    folders = seed_folders(run_dir, config)
    title = f"{env.name}, {short_name(config.algorithm)}, {short_name(config.reward)} reward"
    # The policy it began with may be gone from its old place, so a run has a copy of its own.
    start = {"init_from": str(run_dir / START)} if (run_dir / START).is_file() else {}
    with ExitStack() as stack:
        stack.enter_context(recording_status(run_dir, manifest))
        show = stack.enter_context(show_progress(progress if is_first() else "none", config.num_updates, title, config.seeds))
        compiled = compile_train(make_train(env, config.model_copy(update=start)), config)
        compiled = with_spread_starts(compiled, config, episode_length(env))
        checkpoints = Checkpoints(run_dir)
        stack.callback(checkpoints.close)
        state, done = checkpoints.restore_last(compiled.start())
        if "resumed" in manifest and done < config.num_updates and progress != "none" and is_first():
            print(f"{title}: {resumption(done)}", flush=True)
        manifest.update(compile_seconds=compiled.seconds, program_megabytes=compiled.megabytes)
        recorders = stack.enter_context(open_recorders(folders, env, config, done, manifest["loggers"], title))
        so_far = Progress(done, diverged_before(state, recorders, config))
        try:
            keeping = Keeping(recorders, checkpoints.save, show)
            if callback is not None and is_first():
                keeping = replace(keeping, after_update=_call_after_update(callback, env, config, run_dir))
            state = run_updates(compiled, state, so_far, config, keeping)
        finally:
            manifest.update(
                updates=so_far.updates,
                warnings=said_once({recorder.seed: recorder.history.warnings for recorder in recorders}),
                diverged=[{"seed": seed, "update": update} for seed, update in so_far.diverged.items()],
                seconds=time.perf_counter() - began,
                peak_megabytes=peak_megabytes(),
            )
        if so_far.stopped:
            manifest["status"] = f"stopped by its callback after update {so_far.updates}"
        parameters = jax.device_get(compiled.parameters(state))
    seconds = time.perf_counter() - began
    return Result(run_dir, parameters, so_far.updates, so_far.diverged, folders, compiled.seconds, seconds, peak_megabytes())


def _call_after_update(callback: Callback, env: Environment, config: Config, run_dir: Path) -> AfterUpdate:
    """Returns a function that calls the callback with an `Update`, and returns whether it ends the run."""

    def after_update(number: int, rows: Sequence[Row], learning: Sequence[int], parameters: Any) -> bool:
        def policy_of(seed: int) -> Policy:
            own = of_seed(parameters, config.seed_numbers.index(seed), config)
            return trained_policy(env, config, jax.tree.map(jnp.copy, own))  # the next update reuses their memory

        known = {config.seed_numbers[index]: rows[index] for index in learning}
        row = mean_row([*known.values()])
        return callback(Update(number, row["env_steps"], row, known, run_dir, policy_of)) is True

    return after_update


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
            raise RunError(str(error)) from None
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
