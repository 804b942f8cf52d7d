"""Runs cells: whoever calls `run_cell` with a folder, on whatever machine, the cell is run once, and gone on with where it was stopped."""

import gc
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import jax
import numpy as np

import sjdsl
from sjdsl.experiments.players import acting_kind
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.files import UNFINISHED
from sjdsl.sweeps.cells import Cell
from sjdsl.sweeps.folder import (
    EVALUATION,
    cells_at,
    diverged_in,
    evaluation_of,
    is_finished,
    manifest_of,
    progress_of,
    read_sweep,
    record_failure,
    run_dir,
    seed_dirs,
)
from sjdsl.sweeps.locks import take
from sjdsl.sweeps.tables import collective_returns, write_status, write_tables
from sjdsl.trainers.checkpoints import CHECKPOINTS
from sjdsl.trainers.config import ConfigError, make_config, stored_config
from sjdsl.trainers.evaluation import Evaluation, evaluation_key, make_evaluator, save_evaluation
from sjdsl.trainers.manifest import MANIFEST
from sjdsl.trainers.policies import PolicyError, read_parameters, trained_policy
from sjdsl.trainers.policy_file import START, policy_path
from sjdsl.trainers.progress import ProgressStyle
from sjdsl.trainers.run import Run, train_side_by_side
from sjdsl.trainers.run_errors import DiskError, RunError, TooLargeError
from sjdsl.trainers.run_lock import LOCK
from sjdsl.trainers.side_by_side import kind_of

Tell = Callable[[str], None]
REFUSALS = (RunError, ConfigError, PolicyError, ExperimentError)
OVER = ("done", "failed")


@dataclass(frozen=True)
class Watch:
    """How runs are looked after."""

    progress: ProgressStyle = "none"
    tell: Tell = lambda _: None


ALONE = Watch()


def run_cell(folder: Path | str) -> str:
    """Runs the cell in a folder `DIR/cells/NAME` of a sweep, unless it is done, has failed, or another process runs it.

    A cell that was stopped goes on from its last checkpoint. The tables of the sweep are brought up to date.

    Returns:
      how far the cell is then: `done`, `failed`, `running` (elsewhere).
    Raises:
      DiskError, OSError: the disk is full; what was written before stays. ExperimentError: it is no cell of a sweep. NotAllowed: it needs
      code that the caller has not named (`allow_code`).
    """
    for cell in cells_at([folder])[2]:
        cell.require_code()
    return run_cells([folder])[0]


def run_cells(folders: Sequence[Path | str], watch: Watch = ALONE) -> list[str]:
    """Runs several cells of one sweep, as `run_cell` does: those that differ in numbers without shape as one program."""
    sweep, known, cells = cells_at(folders)
    for cell in cells:
        make_config(cell.config, asked=())  # whoever has cells run names their code
    try:
        with _locked(sweep, cells, known["episodes"]) as ours:
            write_status(sweep, known)
            _run(sweep, ours, known["episodes"], watch)
    except BaseException:  # also where a user interrupts: nobody runs the cells any more
        with suppress(OSError, ExperimentError):  # the disk may be full
            write_status(sweep, read_sweep(sweep))  # another process may have added cells
        raise
    known = read_sweep(sweep)  # another process may have added cells
    write_tables(sweep, known)
    for cell in ours:
        _tell_end(sweep, cell, known, watch.tell)
    jax.clear_caches()  # compiled programs would fill the memory in the course of a long sweep
    gc.collect()
    return [progress_of(sweep, cell, known["episodes"]).state for cell in cells]


@contextmanager
def _locked(sweep: Path, cells: Sequence[Cell], episodes: int) -> Iterator[list[Cell]]:
    """Yields the cells that are to be run here, and keeps other processes from running them."""
    with ExitStack() as stack:
        ours = []
        for cell in cells:
            lock = None if progress_of(sweep, cell, episodes).state in OVER else take(sweep, cell.name)
            if lock is None:
                continue
            stack.callback(lock.release)
            if progress_of(sweep, cell, episodes).state not in OVER:  # another may have done it meanwhile
                ours.append(cell)
        yield ours


def _run(sweep: Path, cells: Sequence[Cell], episodes: int, watch: Watch) -> None:
    """Trains cells that this process has locked, side by side where that can be, and evaluates them."""
    waiting = _groups(sweep, cells)
    while waiting:
        group = waiting.pop(0)
        try:
            _train(sweep, group, watch)
        except TooLargeError as error:
            if len(group) > 1:
                half = (len(group) + 1) // 2
                watch.tell(f"{len(group)} cells do not fit into memory together; {half} at a time")
                waiting[:0] = [group[:half], group[half:]]
                continue
            record_failure(sweep, group[0], str(error))
        except (DiskError, OSError):
            raise
        except Exception as error:  # a reward, a network or a policy of the user's own may raise anything: the other cells go on
            left = [cell for cell in group if _is_open(sweep, cell)]
            if len(group) > 1 and left:
                watch.tell(f"{_said(error)}; so {', '.join(cell.name for cell in left)} are run one by one")
                waiting[:0] = [[cell] for cell in left]
            elif left:
                record_failure(sweep, group[0], _said(error))
        for cell in group:
            _finish(sweep, cell, episodes)


def _is_open(sweep: Path, cell: Cell) -> bool:
    """Whether the run of a cell has updates left to do, and can do them."""
    path = run_dir(sweep, cell)
    return not is_finished(path) and not diverged_in(path)


def _said(error: Exception) -> str:
    """Returns what a fault says: of one that is no refusal of ours also its class."""
    return str(error) if isinstance(error, REFUSALS) else f"{type(error).__name__}: {error}"


def _groups(sweep: Path, cells: Sequence[Cell]) -> list[list[Cell]]:
    """Returns cells in groups that one program can run: of one kind, and with a checkpoint of the same update, or without any."""
    groups: list[tuple[Any, set[str], list[Cell]]] = []
    for cell in cells:
        kind = kind_of(environment_of(cell), cell.configuration())
        saved = {path.name for path in (run_dir(sweep, cell) / CHECKPOINTS).glob("*") if path.name.isdecimal()}
        for other, common, members in groups:
            if kind == other and (common & saved or not (common or saved)):
                common &= saved
                members.append(cell)
                break
        else:
            groups.append((kind, saved, [cell]))
    return [members for _, _, members in groups]


def _train(sweep: Path, group: Sequence[Cell], watch: Watch) -> None:
    """Trains the cells of a group that are not finished."""
    left = [cell for cell in group if _is_open(sweep, cell)]
    if not left:
        return
    known = read_sweep(sweep)
    runs = []
    for cell in left:
        path = run_dir(sweep, cell)
        _clear_half_begun(path)
        asked = {"episodes": known["episodes"]}
        runs.append(Run(environment_of(cell), cell.configuration(), path, cell.provenance, known["loggers"], asked))
        again = ", from its last checkpoint" if (path / MANIFEST).is_file() else ""
        watch.tell(f"{cell.name}: training{again}{' side by side' if len(left) > 1 else ''}")
    train_side_by_side(runs, watch.progress)


def _clear_half_begun(path: Path) -> None:
    """Removes what a run leaves that was stopped before its manifest was written: nothing but a copy of the policy it starts with, and its lock.

    Raises ExperimentError where there is more: these are files of something else, and stay.
    """
    if not path.is_dir() or (path / MANIFEST).is_file():
        return
    inside = sorted(found.name for found in path.iterdir())
    ours = {START, str(Path(START).with_suffix(".json")), MANIFEST, LOCK}
    others = [name for name in inside if name not in ours and not name.endswith(UNFINISHED)]
    if others:
        raise ExperimentError(
            f"{path} holds {', '.join(others[:3])} and no {MANIFEST} that says of which run; --retry puts it aside and begins anew"
        )
    for name in inside:
        (path / name).unlink()


def _finish(sweep: Path, cell: Cell, episodes: int) -> None:
    """Evaluates a cell whose run is finished; writes down that it has failed if a seed has diverged."""
    path = run_dir(sweep, cell)
    diverged = diverged_in(path)
    if diverged:
        record_failure(sweep, cell, f"{diverged}. Its figures are in no table")
        return
    if not is_finished(path):
        return
    try:
        evaluate_cell(path, cell, episodes)
    except REFUSALS as error:
        record_failure(sweep, cell, str(error))


def evaluate_cell(path: Path, cell: Cell, episodes: int) -> None:
    """Plays episodes with the last policy of each seed, and writes `evaluation.json` as `sjdsl train` does; what is there is kept.

    Raises:
      PolicyError: a policy cannot be read. ExperimentError: a return is not finite.
    """
    env = environment_of(cell)
    trained_as = stored_config(manifest_of(path).get("config", cell.config))
    for seed, own in seed_dirs(path, cell).items():
        if evaluation_of(own, seed, episodes) is not None:
            continue
        play = _evaluator(json.dumps(cell.provenance, sort_keys=True), acting_kind(trained_as), episodes)
        parameters, _ = read_parameters(policy_path(own, "last"), env)
        played = play(evaluation_key(seed), parameters)
        if not np.isfinite(played.returns).all():
            raise ExperimentError(f"the returns of the last policy of seed {seed} are not finite: no mean can be made of them")
        save_evaluation(played, own / EVALUATION, {"policy": "last", "seed": seed, "greedy": None})


@lru_cache(maxsize=4)
def _evaluator(provenance: str, acting: str, episodes: int) -> Callable[[Any, Any], Evaluation]:
    """Returns what evaluates policies of one network in one game, compiled once for the seeds of a cell, and for cells alike."""
    env = _environment(provenance)
    config = stored_config(json.loads(acting))
    return make_evaluator(env, lambda parameters: trained_policy(env, config, parameters), episodes)


def environment_of(cell: Cell) -> Any:
    """Returns the environment of a cell.

    Raises:
      ExperimentError: its rules have changed since the sweep was begun.
    """
    env = _environment(json.dumps(cell.provenance, sort_keys=True))
    if env.hash != cell.hash:
        raise ExperimentError(
            f"the rules of {cell.game} have changed since the sweep was begun: {cell.hash} then, {env.hash} now; "
            "go on with the file as it was, or begin another sweep"
        )
    return env


@lru_cache(maxsize=32)
def _environment(provenance: str) -> Any:
    arguments: Mapping[str, Any] = json.loads(provenance)
    return sjdsl.make(**arguments)


def _tell_end(sweep: Path, cell: Cell, known: Mapping[str, Any], tell: Tell) -> None:
    progress = progress_of(sweep, cell, known["episodes"])
    if progress.state == "done":
        returns = collective_returns(sweep, known)[cell.name]
        seeds = f"mean of {len(returns)} seeds" if len(returns) > 1 else "one seed"
        tell(f"{cell.name}: done, collective return {sum(returns) / len(returns):.4g} ({seeds})")
    elif progress.state == "failed":
        tell(f"{cell.name}: {progress.summary}")
