"""A whole sweep: plans it, runs the cells that aren't done, and writes its table."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import sjdsl
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.sweeps.cells import Cell, Describe, SweepSpec
from sjdsl.sweeps.folder import (
    describe_sweep,
    merge_sweep,
    progress_of,
    read_sweep,
    retry,
    run_dir,
    write_sweep,
)
from sjdsl.sweeps.gpus import describe_shares, gpus_for_workers
from sjdsl.sweeps.locks import take_lock
from sjdsl.sweeps.plan import plan_sweep
from sjdsl.sweeps.processes import run_in_processes
from sjdsl.sweeps.tables import write_results
from sjdsl.sweeps.work import SILENT, Watch, run_cell, stages_of
from sjdsl.trainers.policies.loading import PolicyError
from sjdsl.trainers.runs.loggers import check_loggers
from sjdsl.trainers.runs.run import check_stages
from sjdsl.trainers.settings.config import ConfigError

PATIENCE = 2.0  # seconds between two checks of cells that other processes run


@dataclass(frozen=True)
class Outcome:
    """The result of a sweep."""

    folder: Path
    done: tuple[str, ...]  # names of cells
    failed: Mapping[str, str]  # cell -> reason
    stopped: tuple[str, ...]  # the remaining cells


def sweep(
    spec: SweepSpec,
    folder: Path | str,
    describe: Describe | None = None,
    workers: int = 1,
    again: bool = False,
    watch: Watch = SILENT,
) -> Outcome:
    """Runs a sweep, or resumes it: cells that are done stay, stopped ones resume from their last
    checkpoint.

    Args:
      spec: the games, axes and settings. Cells that the folder doesn't have yet are added to it.
      folder: of the sweep; new, empty, or of the same sweep.
      describe: returns the arguments of an environment, its name and its hash; None: by
        `sjdsl.make`.
      workers: processes on this machine, at most; 1: this one. If it has NVIDIA GPUs, each of
        several has one of them, or shares it, and this process computes on the CPU from then on.
      again: whether to try failed cells again.
      watch: shows the progress of runs in this process, and gets a line for each event; other
        processes write theirs to standard error.
    Raises:
      ExperimentError: the specification is inconsistent, or the folder holds something else.
        DiskError, OSError: the disk is full; the same call resumes the sweep.
    """
    path = Path(folder).resolve()
    gpus = gpus_for_workers(workers)
    cells = _prepare(spec, path, describe)
    if gpus:
        watch.tell(describe_shares(gpus, min(workers, len(cells))))
    if again:
        _retry_failed(path, cells, spec.episodes)
    _run_until_done(path, cells, spec.episodes, workers, gpus, watch)
    write_results(path, read_sweep(path))
    done = []
    failed = {}
    stopped = []
    for cell in cells:
        progress = progress_of(path, cell, spec.episodes)
        match progress.state:
            case "done":
                done.append(cell.name)
            case "failed":
                failed[cell.name] = progress.reason
            case _:
                stopped.append(cell.name)
    return Outcome(path, tuple(done), failed, tuple(stopped))


def _retry_failed(folder: Path, cells: Sequence[Cell], episodes: int) -> None:
    """Lets failed cells run again, unless another process is running them."""
    for cell in cells:
        if progress_of(folder, cell, episodes).state != "failed":
            continue
        lock = take_lock(folder, cell.name)
        if lock is not None:
            try:
                retry(folder, cell)
            finally:
                lock.release()


def prepare(spec: SweepSpec, folder: Path | str, describe: Describe | None = None) -> list[Path]:
    """Writes `sweep.json` and returns the folders of all cells, for `run_cell` in any process on
    any machine.

    Arguments and errors are those of `sweep`.
    """
    path = Path(folder).resolve()
    return [run_dir(path, cell) for cell in _prepare(spec, path, describe)]


def _prepare(spec: SweepSpec, path: Path, describe: Describe | None) -> tuple[Cell, ...]:
    """Writes `sweep.json`; returns the cells."""
    cells = plan_sweep(spec, describe or describe_with_make)
    check_sweep(spec, cells, path)
    write_sweep(path, describe_sweep(spec, cells))
    return cells


def check_sweep(spec: SweepSpec, cells: Sequence[Cell], folder: Path) -> None:
    """Raises ExperimentError for a logger, a folder or a configuration that can't be used.

    Nothing is written.
    """
    check_loggers(spec.loggers)
    merge_sweep(folder, describe_sweep(spec, cells))
    checked = set()
    for cell in cells:
        kind = repr([(stage.hash, _without_floats(stage.config)) for stage in cell.stages])
        if kind in checked:
            continue
        checked.add(kind)
        try:
            check_stages(stages_of(cell, folder))
        except (ConfigError, PolicyError) as error:
            raise ExperimentError(f"{cell.name}: {error}") from None


def _without_floats(config: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the settings that decide whether a configuration fits a game: no float does."""
    return {key: value for key, value in config.items() if not isinstance(value, float)}


def describe_with_make(
    game: str,
    variant: str | None,
    params: Mapping[str, Any],
    map: str | None = None,
    num_agents: int | None = None,
    **of_tasks: Any,
) -> tuple[dict[str, Any], str, str]:
    """Returns the arguments of a game's environment, its name and its hash."""
    provenance: dict[str, Any] = {
        "game": str(Path(game).resolve()) if Path(game).suffix else game,
        "variant": variant,
        "map": None if map is None else str(Path(map).resolve()),
        "num_agents": num_agents,
        "params": dict(params),
        **of_tasks,
    }
    env = sjdsl.make(**provenance)
    return provenance, env.name, env.hash


def _run_until_done(
    folder: Path,
    cells: Sequence[Cell],
    episodes: int,
    workers: int,
    gpus: Sequence[str],
    watch: Watch,
) -> None:
    """Runs cells until each is done or has failed, in this process or another, or until a process
    that it has started is killed."""
    reported: set[str] = set()
    # A single cell isn't worth another process, unless that one has a GPU, which this one hasn't.
    fewest_for_processes = 1 if gpus else 2
    while True:
        states = {cell.name: progress_of(folder, cell, episodes).state for cell in cells}
        waiting = [name for name, state in states.items() if state in ("waiting", "stopped")]
        running = [name for name, state in states.items() if state == "running"]
        paths = [run_dir(folder, cell) for cell in cells if cell.name in waiting]
        if workers > 1 and len(paths) >= fewest_for_processes:
            if not run_in_processes(paths, workers, gpus):
                return
        elif paths:
            for path in paths:
                run_cell(path, watch)
        elif running:
            for name in running:
                if name not in reported:
                    watch.tell(f"{name}: waiting for the process that runs it")
            reported.update(running)
            time.sleep(PATIENCE)
        else:
            return
