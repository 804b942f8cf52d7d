"""Runs a whole training: starts a new folder or resumes one, runs all updates, and returns the trained policies."""

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import zip_longest
from pathlib import Path
from typing import Any

import jax

from .algorithms import make_train
from .checkpoints import Checkpoints
from .compiled import NoMemoryError, compile_train, peak_megabytes
from .config import Config, make_config
from .environment import Environment
from .loggers import LoggerName
from .metric_rows import mean_row
from .metrics_files import METRICS_JSONL, Row, read_rows
from .policy_file import START, copy_policy
from .processes import any_says, is_first
from .progress import ProgressStyle, show_progress
from .recorder import open_recorders
from .resuming import RunError, check_same_run, extended, restore_last
from .run_files import write_json
from .run_folder import MANIFEST, describe_run, seed_folders
from .updates import Callback, Keeping, Progress, diverged_before, make_teller, run_updates

__all__ = ["Result", "RunError", "resume", "train"]


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
      RunError: the folder is in use, training diverged with every seed, or the disk or the memory is full; what was written until then stays.
      ConfigError: the configuration does not fit the environment. PolicyError: a policy that it names cannot be read.
    """
    run_dir = Path(run_dir)
    if any_says(run_dir.exists() and (not run_dir.is_dir() or any(run_dir.iterdir()))):
        raise RunError(f"{run_dir} is not empty; name a new folder, so that no earlier run is lost, or resume the run in it")
    make_train(env, config)  # what does not fit is said before the folder is made
    run_dir.mkdir(parents=True, exist_ok=True)
    if config.init_from and is_first():
        copy_policy(config.init_from, run_dir / START)
    manifest = describe_run(env, config, provenance or {}) | {"loggers": list(loggers), "asked": dict(asked or {})}
    return _run(env, config, run_dir, progress, manifest, callback)


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
      RunError: no such run, or it was of another game or of other versions, or it has done more steps already.
    """
    run_dir = Path(run_dir)
    manifest = check_same_run(env, run_dir)
    if total_timesteps is not None:
        manifest = extended(manifest, run_dir, total_timesteps)
    manifest |= {"status": "running", "resumed": [*manifest.get("resumed", []), datetime.now(UTC).isoformat(timespec="seconds")]}
    manifest |= {"loggers": list(manifest.get("loggers", ()) if loggers is None else loggers)}
    manifest |= {"asked": manifest.get("asked", {}) | dict(asked or {})}
    return _run(env, make_config(manifest["config"]), run_dir, progress, manifest, callback)


def _run(
    env: Environment, config: Config, run_dir: Path, progress: ProgressStyle, manifest: dict[str, Any], callback: Callback | None
) -> Result:
    began = time.perf_counter()
    title = f"{env.name}, {config.algorithm}, {config.reward} reward"
    folders = seed_folders(run_dir, config)
    with ExitStack() as stack:
        stack.enter_context(_told(run_dir, manifest))
        show = stack.enter_context(show_progress(progress if is_first() else "none", config.num_updates, title, config.seeds))
        start = run_dir / START  # not where it was copied from, which may be gone
        program = make_train(env, config.model_copy(update={"init_from": str(start)}) if start.is_file() else config)
        compiled = compile_train(program, config)
        manifest |= {"compile_seconds": compiled.seconds, "program_megabytes": compiled.megabytes}
        checkpoints = Checkpoints(run_dir)
        stack.callback(checkpoints.close)
        state, done = restore_last(checkpoints, compiled)
        recorders = stack.enter_context(open_recorders(folders, env, config, done, manifest["loggers"], title))
        so_far = Progress(done, diverged_before(state, recorders, config))
        try:
            told = () if callback is None or not is_first() else (make_teller(callback, env, config, run_dir),)
            state = run_updates(compiled, state, so_far, config, Keeping(recorders, checkpoints, show, *told))
        finally:
            manifest |= {
                "updates": so_far.updates,
                "diverged": [{"seed": seed, "update": update} for seed, update in so_far.diverged.items()],
                "seconds": time.perf_counter() - began,
                "peak_megabytes": peak_megabytes(),
            }
        if so_far.stopped:
            manifest["status"] = f"stopped by its callback after update {so_far.updates}"
        parameters = jax.device_get(compiled.parameters(state))
    seconds = time.perf_counter() - began
    return Result(run_dir, parameters, so_far.updates, so_far.diverged, folders, compiled.seconds, seconds, peak_megabytes())


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
