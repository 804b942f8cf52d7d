"""Runs cells: however many processes call `run_cell` on a folder, on any machine, the cell runs once, and resumes if it was stopped."""

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
    """How to show the progress of runs."""

    progress: ProgressStyle = "none"
    tell: Tell = lambda _: None


ALONE = Watch()


def run_cell(folder: Path | str) -> str:
    """Runs the cell in a folder `DIR/cells/NAME` of a sweep, unless it is done, has failed, or is running in another process.

    A cell that was stopped resumes from its last checkpoint. The tables of the sweep are updated.

    Returns:
      the cell's state afterwards: `done`, `failed`, or `running` (elsewhere).
    Raises:
      DiskError, OSError: the disk is full; what was written before stays. ExperimentError: the folder isn't a cell of a sweep. NotAllowed:
      the cell needs code that the caller hasn't allowed (`allow_code`).
    """
    for cell in cells_at([folder])[2]:
        cell.require_code()
    return run_cells([folder])[0]


def run_cells(folders: Sequence[Path | str], watch: Watch = ALONE) -> list[str]:
    """Runs several cells of one sweep, as `run_cell` does; those that differ only in numbers without shape run as one program."""
    sweep, known, cells = cells_at(folders)
    for cell in cells:
        make_config(cell.config, asked=())  # imports the code that it names
    try:
        with _locked(sweep, cells, known["episodes"]) as ours:
            write_status(sweep, known)
            _run(sweep, ours, known["episodes"], watch)
    except BaseException:  # an interruption too: the cells aren't running any more
        with suppress(OSError, ExperimentError):  # the disk may be full
            write_status(sweep, read_sweep(sweep))  # another process may have added cells
        raise
    known = read_sweep(sweep)  # another process may have added cells
    write_tables(sweep, known)
    for cell in ours:
        progress = progress_of(sweep, cell, known["episodes"])
        if progress.state == "done":
            returns = collective_returns(sweep, known)[cell.name]
            seeds = f"mean of {len(returns)} seeds" if len(returns) > 1 else "one seed"
            watch.tell(f"{cell.name}: done, collective return {sum(returns) / len(returns):.4g} ({seeds})")
        elif progress.state == "failed":
            watch.tell(f"{cell.name}: {progress.summary}")
    jax.clear_caches()  # compiled programs would fill the memory in the course of a long sweep
    gc.collect()
    return [progress_of(sweep, cell, known["episodes"]).state for cell in cells]


@contextmanager
def _locked(sweep: Path, cells: Sequence[Cell], episodes: int) -> Iterator[list[Cell]]:
    """Yields the cells to run in this process, and holds their locks meanwhile."""
    with ExitStack() as stack:
        ours = []
        for cell in cells:
            lock = None if progress_of(sweep, cell, episodes).state in OVER else take(sweep, cell.name)
            if lock is None:
                continue
            stack.callback(lock.release)
            if progress_of(sweep, cell, episodes).state not in OVER:  # another process may have finished it meanwhile
                ours.append(cell)
        yield ours


def _run(sweep: Path, cells: Sequence[Cell], episodes: int, watch: Watch) -> None:
    """Trains the cells that this process has locked, side by side where possible, and evaluates them."""
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
        except Exception as error:  # code of the user's own may raise anything: the other cells continue
            left = [cell for cell in group if _is_open(sweep, cell)]
            if len(group) > 1 and left:
                watch.tell(f"{_message(error)}; running {', '.join(cell.name for cell in left)} one by one")
                waiting[:0] = [[cell] for cell in left]
            elif left:
                record_failure(sweep, group[0], _message(error))
        for cell in group:
            _finish(sweep, cell, episodes)


def _is_open(sweep: Path, cell: Cell) -> bool:
    """Whether the run of a cell has updates left, and can continue."""
    path = run_dir(sweep, cell)
    return not is_finished(path) and not diverged_in(path)


def _message(error: Exception) -> str:
    """Returns the message of an error, with its class unless it is one of ours."""
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
    """Trains the cells of a group that aren't finished."""
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
    """Removes the files of a run that was stopped before it wrote its manifest: a copy of the policy it starts with, and its lock.

    Raises ExperimentError if there are other files; they stay.
    """
    if not path.is_dir() or (path / MANIFEST).is_file():
        return
    inside = sorted(found.name for found in path.iterdir())
    ours = {START, str(Path(START).with_suffix(".json")), MANIFEST, LOCK}
    others = [name for name in inside if name not in ours and not name.endswith(UNFINISHED)]
    if others:
        raise ExperimentError(f"{path} holds {', '.join(others[:3])} but no {MANIFEST}; --retry moves it aside and starts again")
    for name in inside:
        (path / name).unlink()


def _finish(sweep: Path, cell: Cell, episodes: int) -> None:
    """Evaluates a cell whose run is finished; records a failure if a seed has diverged."""
    path = run_dir(sweep, cell)
    diverged = diverged_in(path)
    if diverged:
        record_failure(sweep, cell, f"{diverged}. The tables leave it out")
        return
    if not is_finished(path):
        return
    try:
        evaluate_cell(path, cell, episodes)
    except REFUSALS as error:
        record_failure(sweep, cell, str(error))


def evaluate_cell(path: Path, cell: Cell, episodes: int) -> None:
    """Plays episodes with the last policy of each seed, and writes `evaluation.json` as `sjdsl train` does, unless it is there already.

    Raises:
      PolicyError: a policy can't be read. ExperimentError: a return is not finite.
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
            raise ExperimentError(f"the returns of the last policy of seed {seed} are not finite, so they have no mean")
        save_evaluation(played, own / EVALUATION, {"policy": "last", "seed": seed, "greedy": None})


@lru_cache(maxsize=4)
def _evaluator(provenance: str, acting: str, episodes: int) -> Callable[[Any, Any], Evaluation]:
    """Returns an evaluator of policies with one network in one game, compiled once for all seeds and cells that share them."""
    env = _environment(provenance)
    config = stored_config(json.loads(acting))
    return make_evaluator(env, lambda parameters: trained_policy(env, config, parameters), episodes)


def environment_of(cell: Cell) -> Any:
    """Returns the environment of a cell.

    Raises:
      ExperimentError: its rules have changed since the sweep began.
    """
    env = _environment(json.dumps(cell.provenance, sort_keys=True))
    if env.hash != cell.hash:
        raise ExperimentError(
            f"the rules of {cell.game} have changed since the sweep began: {cell.hash} then, {env.hash} now; "
            "restore the file, or start another sweep"
        )
    return env


@lru_cache(maxsize=32)
def _environment(provenance: str) -> Any:
    arguments: Mapping[str, Any] = json.loads(provenance)
    return sjdsl.make(**arguments)
