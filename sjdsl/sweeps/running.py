"""A whole sweep: plans it, runs what is left, and writes its table."""

import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import sjdsl
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.sweeps.cells import Cell, Describe, SweepSpec
from sjdsl.sweeps.folder import describe_sweep, merged, progress_of, read_sweep, retry, run_dir, write_sweep
from sjdsl.sweeps.locks import take
from sjdsl.sweeps.plan import Plan, plan_sweep, second_stage
from sjdsl.sweeps.processes import run_in_processes
from sjdsl.sweeps.protocols import SETS
from sjdsl.sweeps.tables import collective_returns, write_results
from sjdsl.sweeps.work import ALONE, Watch, environment_of, run_cell
from sjdsl.trainers.algorithms import make_train
from sjdsl.trainers.config import ConfigError
from sjdsl.trainers.loggers import check_loggers
from sjdsl.trainers.policies import PolicyError

PATIENCE = 2.0  # seconds between two checks of cells that other processes run


@dataclass(frozen=True)
class Outcome:
    """The result of a sweep."""

    folder: Path
    done: tuple[str, ...]  # names of cells
    failed: Mapping[str, str]  # cell -> reason
    stopped: tuple[str, ...]  # the remaining cells
    complete: bool  # whether all stages were run


def sweep(
    spec: SweepSpec,
    folder: Path | str,
    describe: Describe | None = None,
    workers: int = 1,
    again: bool = False,
    watch: Watch = ALONE,
) -> Outcome:
    """Runs a sweep, or resumes it: cells that are done stay, stopped ones resume from their last checkpoint.

    Args:
      spec: what to train. Values that the folder doesn't have yet are added to it.
      folder: of the sweep; new, empty, or of the same sweep.
      describe: returns the arguments of an environment, its name and its hash; None: by `sjdsl.make`.
      workers: processes on this machine, at most; 1: this one.
      again: whether to try failed cells again.
      watch: shows the progress of runs in this process, and gets a line for each event.
    Raises:
      ExperimentError: the specification is inconsistent, or the folder holds something else. DiskError, OSError: the disk is full;
      the same call resumes the sweep.
    """
    path = Path(folder).resolve()
    plan, cells, following = _prepared(spec, path, describe)
    for cell in cells if again else ():
        if progress_of(path, cell, spec.episodes).state == "failed" and (lock := take(path, cell.name)) is not None:
            try:
                retry(path, cell)
            finally:
                lock.release()
    _run_stage(path, plan.cells, spec.episodes, workers, watch)
    if plan.has_second_stage:
        _, cells, following = _prepared(spec, path, describe)
        if following is None:
            watch.tell("the second stage begins when every cell of the first is done")
        else:
            for line in _best_weights(following):
                watch.tell(line)
            _run_stage(path, following, spec.episodes, workers, watch)
    write_results(path, read_sweep(path))
    states = {cell.name: progress_of(path, cell, spec.episodes) for cell in cells}
    return Outcome(
        path,
        tuple(name for name, found in states.items() if found.state == "done"),
        {name: found.reason for name, found in states.items() if found.state == "failed"},
        tuple(name for name, found in states.items() if found.state not in ("done", "failed")),
        complete=following is not None,
    )


def prepare(spec: SweepSpec, folder: Path | str, describe: Describe | None = None) -> list[Path]:
    """Writes `sweep.json` and returns the folders of all cells, for `run_cell` in any process on any machine.

    In a protocol of two stages, the cells of the second are among them as soon as all of the first are done. Arguments and errors are
    those of `sweep`.
    """
    path = Path(folder).resolve()
    return [run_dir(path, cell) for cell in _prepared(spec, path, describe)[1]]


def _prepared(spec: SweepSpec, path: Path, describe: Describe | None) -> tuple[Plan, list[Cell], list[Cell] | None]:
    """Writes `sweep.json`; returns the plan, all cells known so far, and those of a second stage (None if it can't begin yet)."""
    plan = plan_sweep(spec, describe or describe_with_make)
    check_sweep(plan, path)
    known = write_sweep(path, describe_sweep(spec, plan.cells))
    following = following_cells(path, plan, known) if plan.has_second_stage else []
    cells = [*plan.cells, *(following or ())]
    write_sweep(path, describe_sweep(spec, cells))
    return plan, cells, following


def _best_weights(following: Sequence[Cell]) -> Iterable[str]:
    """Returns a line for each game and combination of axes that says which weight was best."""
    return dict.fromkeys(
        f"second stage of {cell.game}{''.join(f', {name} {value}' for name, value in cell.values.items() if name not in SETS['svo'])}: "
        f"weight {cell.values['svo_weight']:g} was best, seeds {cell.seeds[0]} to {cell.seeds[-1]}"
        + ("; at weight 0 all angles are the same, so one is trained" if not cell.values["svo_weight"] else "")
        for cell in following
    )


def check_sweep(plan: Plan, folder: Path) -> dict[str, Any]:
    """Returns the new content of `sweep.json`.

    Raises:
      ExperimentError: a logger, a folder or a configuration is refused; nothing has been written.
    """
    check_loggers(plan.spec.loggers)
    known = merged(folder, describe_sweep(plan.spec, plan.cells))
    check_cells(plan.cells)
    return known


def check_cells(cells: Sequence[Cell]) -> None:
    """Raises ExperimentError if a configuration doesn't fit its game, before anything is written."""
    checked = set()
    for cell in cells:
        kind = cell.hash, repr({key: value for key, value in cell.config.items() if not isinstance(value, float)})
        if kind in checked:
            continue  # floats alone don't decide what fits
        checked.add(kind)
        try:
            make_train(environment_of(cell), cell.configuration())
        except (ConfigError, PolicyError) as error:
            raise ExperimentError(f"{cell.name}: {error}") from None


def following_cells(folder: Path, plan: Plan, known: Mapping[str, Any]) -> list[Cell] | None:
    """Returns the cells of the second stage; None until all of the first are done: the best of only some would be no choice."""
    returns = collective_returns(folder, known)
    if any(cell.name not in returns for cell in plan.cells):
        return None
    return second_stage(plan, returns)


def describe_with_make(game: str, variant: str | None, params: Mapping[str, Any]) -> tuple[dict[str, Any], str, str]:
    """Returns the arguments of a game's environment, its name and its hash."""
    path = Path(game)
    name = str(path.resolve()) if path.suffix else game
    provenance = {"game": name, "variant": variant, "map": None, "num_agents": None, "params": dict(params)}
    env = sjdsl.make(name, variant=variant, params=params)
    return provenance, env.name, env.hash


def _run_stage(folder: Path, cells: Sequence[Cell], episodes: int, workers: int, watch: Watch) -> None:
    """Runs cells until each is done or has failed, in this process or another."""
    reported: set[str] = set()
    while True:
        states = {cell.name: progress_of(folder, cell, episodes).state for cell in cells}
        left = [cell for cell in cells if states[cell.name] in ("waiting", "stopped")]
        if left:
            folders = [run_dir(folder, cell) for cell in left]
            if workers > 1 and len(folders) > 1:
                run_in_processes(folders, workers, watch.tell)
            else:
                for path in folders:
                    run_cell(path, watch)
            continue
        running = [name for name, state in states.items() if state == "running"]
        if not running:
            return
        for name in running:
            if name not in reported:
                watch.tell(f"{name}: waiting for the process that runs it")
        reported.update(running)
        time.sleep(PATIENCE)
