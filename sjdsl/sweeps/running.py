"""A whole sweep: plans it, runs what is left of it, and writes its tables."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax

import sjdsl
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.sweeps.cells import Cell, Describe
from sjdsl.sweeps.folder import describe_sweep, merged, progress_of, read_sweep, retry, run_dir, write_sweep
from sjdsl.sweeps.locks import take
from sjdsl.sweeps.plan import Asked, Plan, plan_sweep, second_stage
from sjdsl.sweeps.processes import Batch, run_in_processes
from sjdsl.sweeps.protocols import SETS
from sjdsl.sweeps.tables import collective_returns, write_tables
from sjdsl.sweeps.work import ALONE, Tell, Watch, environment_of, run_cells
from sjdsl.trainers.algorithms import make_train
from sjdsl.trainers.config import ConfigError
from sjdsl.trainers.loggers import check_loggers
from sjdsl.trainers.policies import PolicyError
from sjdsl.trainers.side_by_side import kind_of_config

PATIENCE = 2.0  # seconds between two looks at cells that other processes run


@dataclass(frozen=True)
class Outcome:
    """What came of a sweep."""

    folder: Path
    done: tuple[str, ...]  # names of cells
    failed: Mapping[str, str]  # cell -> reason
    stopped: tuple[str, ...]  # cells that are left
    complete: bool  # whether all stages were run


def sweep(
    asked: Asked,
    folder: Path | str,
    describe: Describe | None = None,
    workers: int = 1,
    together: int | None = None,
    again: bool = False,
    watch: Watch = ALONE,
) -> Outcome:
    """Runs a sweep, or goes on with it: cells that are done are kept, stopped ones go on from their last checkpoint.

    Args:
      asked: what the sweep is to be. Values that the folder does not have are added to it.
      folder: of the sweep; new, empty, or of the same one.
      describe: makes the arguments of an environment, its name and its hash; None: by `sjdsl.make`.
      workers: processes of this machine, at most; 1: this one.
      together: cells that one program trains, at most, where they differ in numbers without shape only. None: one on a CPU, for
        there more are not faster, or with several workers; elsewhere as many as fit into memory.
      again: whether failed cells are tried again.
      watch: shows how far runs in this process are, and is told what happens.
    Raises:
      ExperimentError: what is asked does not fit together, or the folder holds something else. DiskError, OSError: the disk is full;
      the same call goes on.
    """
    path = Path(folder).resolve()
    plan, cells, following = _prepared(asked, path, describe)
    if again:
        _retry(path, cells, asked.episodes)
    _run_stage(path, plan.cells, asked.episodes, workers, together, watch)
    if plan.follows:
        _, cells, following = _prepared(asked, path, describe)
        if following is None:
            watch.tell("the second stage begins when every cell of the first is done")
        else:
            _tell_weights(following, watch.tell)
            _run_stage(path, following, asked.episodes, workers, together, watch)
    write_tables(path, read_sweep(path))
    return _outcome(path, cells, asked.episodes, complete=following is not None)


def prepare(asked: Asked, folder: Path | str, describe: Describe | None = None) -> list[Path]:
    """Writes `sweep.json` and returns the folders of all cells, each of which `run_cell` runs, in whatever process or machine.

    A protocol of two stages has the cells of the second among them as soon as all of the first are done. Arguments and errors are those
    of `sweep`.
    """
    path = Path(folder).resolve()
    return [run_dir(path, cell) for cell in _prepared(asked, path, describe)[1]]


def _prepared(asked: Asked, path: Path, describe: Describe | None) -> tuple[Plan, list[Cell], list[Cell] | None]:
    """Writes `sweep.json`; returns the plan, all cells that there are by now, and those of a second stage, None if it can't begin yet."""
    plan = plan_sweep(asked, describe or describe_with_make)
    check_sweep(asked, plan, path)
    known = write_sweep(path, describe_sweep(asked, plan.cells))
    following = following_cells(path, plan, known) if plan.follows else []
    cells = [*plan.cells, *(following or ())]
    write_sweep(path, describe_sweep(asked, cells))
    return plan, cells, following


def _tell_weights(following: Sequence[Cell], tell: Tell) -> None:
    """Says which weight was best, for each game and combination of axes."""
    for said in dict.fromkeys(
        f"second stage of {cell.game}{''.join(f', {name} {value}' for name, value in cell.values.items() if name not in SETS['svo'])}: "
        f"weight {cell.values['svo_weight']:g} was best, seeds {cell.seeds[0]} to {cell.seeds[-1]}"
        + ("; without weight all angles are alike, and one is trained" if not cell.values["svo_weight"] else "")
        for cell in following
    ):
        tell(said)


def check_sweep(asked: Asked, plan: Plan, folder: Path) -> dict[str, Any]:
    """Returns what `sweep.json` is to say.

    Raises:
      ExperimentError: a logger, a folder or a configuration is refused; nothing has been written.
    """
    check_loggers(asked.loggers)
    known = merged(folder, describe_sweep(asked, plan.cells), plan)
    check_cells(plan.cells)
    return known


def check_cells(cells: Sequence[Cell]) -> None:
    """Raises ExperimentError where a configuration does not fit its game: before anything is written. Cells of one kind are as one."""
    kinds = {(cell.hash, kind_of_config(cell.configuration())): cell for cell in reversed(cells)}
    for cell in reversed(kinds.values()):
        try:
            make_train(environment_of(cell), cell.configuration())
        except (ConfigError, PolicyError) as error:
            raise ExperimentError(f"{cell.name}: {error}") from None


def following_cells(folder: Path, plan: Plan, known: Mapping[str, Any]) -> list[Cell] | None:
    """Returns the cells of the second stage; None as long as one of the first is not done: the best of the others would be no choice."""
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


def _retry(folder: Path, cells: Sequence[Cell], episodes: int) -> None:
    for cell in cells:
        if progress_of(folder, cell, episodes).state != "failed":
            continue
        lock = take(folder, cell.name)
        if lock is None:
            continue
        try:
            retry(folder, cell)
        finally:
            lock.release()


def _run_stage(folder: Path, cells: Sequence[Cell], episodes: int, workers: int, together: int | None, watch: Watch) -> None:
    """Runs cells until each is done or has failed, here or elsewhere."""
    told: set[str] = set()
    at_once = together or (1 if workers > 1 or jax.default_backend() == "cpu" else len(cells))
    while True:
        states = {cell.name: progress_of(folder, cell, episodes).state for cell in cells}
        left = [cell for cell in cells if states[cell.name] in ("waiting", "stopped")]
        if left:
            batches = batches_of(folder, left, at_once)
            if workers > 1 and len(batches) > 1:
                run_in_processes(batches, workers, watch.tell)
            else:
                for batch in batches:
                    run_cells(batch, watch)
            continue
        running = [name for name, state in states.items() if state == "running"]
        if not running:
            return
        for name in running:
            if name not in told:
                watch.tell(f"{name}: waiting for another process, which runs it")
        told.update(running)
        time.sleep(PATIENCE)


def batches_of(folder: Path, cells: Sequence[Cell], at_once: int) -> list[Batch]:
    """Returns the folders of cells in batches, each for one program, in the order of the cells.

    Args:
      at_once: cells of a batch, at most; they differ in numbers without shape only.
    """
    kinds: dict[Any, list[Cell]] = {}
    for cell in cells:
        kinds.setdefault((cell.hash, kind_of_config(cell.configuration())), []).append(cell)
    chunks = [members[start : start + at_once] for members in kinds.values() for start in range(0, len(members), at_once)]
    order = {cell.name: number for number, cell in enumerate(cells)}
    chunks.sort(key=lambda chunk: order[chunk[0].name])
    return [tuple(str(run_dir(folder, cell)) for cell in chunk) for chunk in chunks]


def _outcome(folder: Path, cells: Sequence[Cell], episodes: int, complete: bool) -> Outcome:
    states = {cell.name: progress_of(folder, cell, episodes) for cell in cells}
    return Outcome(
        folder,
        tuple(name for name, found in states.items() if found.state == "done"),
        {name: found.reason for name, found in states.items() if found.state == "failed"},
        tuple(name for name, found in states.items() if found.state not in ("done", "failed")),
        complete,
    )
