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
from sjdsl.sweeps.claims import take
from sjdsl.sweeps.engines import Batch, Crew, check_engine, run_batches
from sjdsl.sweeps.folder import describe_sweep, merged, progress_of, retry, run_dir, write_sweep
from sjdsl.sweeps.plan import Asked, Plan, plan_sweep, second_stage
from sjdsl.sweeps.protocols import SETS
from sjdsl.sweeps.tables import collective_returns, write_tables
from sjdsl.sweeps.work import environment_of
from sjdsl.trainers.algorithms import make_train
from sjdsl.trainers.config import ConfigError
from sjdsl.trainers.loggers import check_loggers
from sjdsl.trainers.policies import PolicyError
from sjdsl.trainers.side_by_side import kind_of_config

ALONE = Crew()  # this process
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
    crew: Crew = ALONE,
    together: int | None = None,
    again: bool = False,
) -> Outcome:
    """Runs a sweep, or goes on with it: cells that are done are kept, stopped ones go on from their last checkpoint.

    Args:
      asked: what the sweep is to be. Values that the folder does not have are added to it.
      folder: of the sweep; new, empty, or of the same one.
      describe: makes the arguments of an environment, its name and its hash; None: by `sjdsl.make`.
      crew: the engine, and how many work side by side.
      together: cells that one program trains, at most, where they differ in numbers without shape only. None: one on a CPU, for
        there more are not faster; elsewhere as many as fit into memory.
      again: whether failed cells are tried again.
    Raises:
      ExperimentError: what is asked does not fit together, or the folder holds something else. DiskError, OSError: the disk is full;
      the same call goes on.
    """
    path = Path(folder).resolve()
    plan = plan_sweep(asked, describe or describe_with_make)
    check_sweep(asked, plan, path, crew)
    known = write_sweep(path, describe_sweep(asked, plan.cells))
    cells = [*plan.cells]
    if again:
        _retry(path, plan.cells, asked.episodes)
    _run_stage(path, cells, asked.episodes, crew, together)
    complete = True
    if plan.follows:
        following = following_cells(path, plan, known)
        complete = following is not None
        if following is None:
            crew.tell("the second stage begins when every cell of the first is done")
        else:
            write_sweep(path, describe_sweep(asked, [*cells, *following]))
            cells += following
            _tell_weights(following, crew)
            if again:
                _retry(path, following, asked.episodes)
            _run_stage(path, following, asked.episodes, crew, together)
    write_tables(path, write_sweep(path, describe_sweep(asked, cells)))
    return _outcome(path, cells, asked.episodes, complete)


def _tell_weights(following: Sequence[Cell], crew: Crew) -> None:
    """Says which weight was best, for each game and combination of axes."""
    for said in dict.fromkeys(
        f"second stage of {cell.game}{''.join(f', {name} {value}' for name, value in cell.values.items() if name not in SETS['svo'])}: "
        f"weight {cell.values['svo_weight']:g} was best, seeds {cell.seeds[0]} to {cell.seeds[-1]}"
        + ("; without weight all angles are alike, and one is trained" if not cell.values["svo_weight"] else "")
        for cell in following
    ):
        crew.tell(said)


def check_sweep(asked: Asked, plan: Plan, folder: Path, crew: Crew) -> dict[str, Any]:
    """Returns what `sweep.json` is to say.

    Raises:
      ExperimentError: an engine, a logger, a folder or a configuration is refused; nothing has been written.
    """
    check_engine(crew)
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
        claim = take(folder, cell.name)
        if claim is None:
            continue
        try:
            retry(folder, cell)
        finally:
            claim.release()


def _run_stage(folder: Path, cells: Sequence[Cell], episodes: int, crew: Crew, together: int | None) -> None:
    """Runs cells until each is done or has failed, here or elsewhere."""
    told: set[str] = set()
    while True:
        states = {cell.name: progress_of(folder, cell, episodes) for cell in cells}
        left = [cell for cell in cells if states[cell.name].state in ("waiting", "stopped")]
        if left:
            run_batches(batches_of(folder, left, _at_once(crew, together)), crew)
            continue
        elsewhere = {name: found.by for name, found in states.items() if found.state == "running"}
        if not elsewhere:
            return
        for name, holder in elsewhere.items():
            if name not in told and holder is not None:
                crew.tell(f"{name}: waiting for the process {holder.pid} on {holder.host}, which runs it")
        told |= elsewhere.keys()
        time.sleep(PATIENCE)


def _at_once(crew: Crew, together: int | None) -> int | None:
    """Returns how many cells a program trains; None for as many as fit."""
    if together is not None:
        return together
    return None if crew.engine == "local" and (crew.workers or 1) == 1 and jax.default_backend() != "cpu" else 1


def batches_of(folder: Path, cells: Sequence[Cell], at_once: int | None) -> list[Batch]:
    """Returns the folders of cells in batches, each for one program, in the order of the cells.

    Args:
      at_once: cells of a batch, at most; None for all that differ in numbers without shape only.
    """
    kinds: dict[Any, list[Cell]] = {}
    for cell in cells:
        kinds.setdefault((cell.hash, kind_of_config(cell.configuration())), []).append(cell)
    size = at_once or len(cells)
    chunks = [members[start : start + size] for members in kinds.values() for start in range(0, len(members), size)]
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
