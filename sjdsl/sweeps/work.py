"""Runs cells: whoever calls `run_cell` with a folder, on whatever machine, the cell is run once, and gone on with where it was stopped."""

import gc
import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
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
from sjdsl.sweeps.claims import BEAT, Claim, take
from sjdsl.sweeps.folder import (
    EVALUATION,
    cells_of,
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
from sjdsl.sweeps.tables import collective_returns, write_status, write_tables
from sjdsl.trainers.checkpoints import CHECKPOINTS
from sjdsl.trainers.config import ConfigError, make_config, stored_config
from sjdsl.trainers.evaluation import Evaluation, evaluation_key, make_evaluator, save_evaluation
from sjdsl.trainers.manifest import MANIFEST
from sjdsl.trainers.policies import PolicyError, read_parameters, trained_policy
from sjdsl.trainers.policy_file import START, policy_path
from sjdsl.trainers.progress import ProgressStyle
from sjdsl.trainers.run import Run, train_side_by_side
from sjdsl.trainers.run_errors import DiskError, RunError, TakenError, TooLargeError
from sjdsl.trainers.run_lock import LOCK
from sjdsl.trainers.side_by_side import kind_of
from sjdsl.trainers.updates import Update

Tell = Callable[[str], None]
REFUSALS = (RunError, ConfigError, PolicyError, ExperimentError)
OVER = ("done", "failed")


@dataclass(frozen=True)
class Watch:
    """How runs are looked after."""

    progress: ProgressStyle = "none"
    tell: Tell = lambda _: None
    stop: Callable[[], bool] = lambda: False  # whether runs are to end after the update under way, and to be gone on with later


ALONE = Watch()


@dataclass
class Held:
    """A cell that this process has claimed."""

    cell: Cell
    claim: Claim
    checked: float = 0.0  # when the claim was looked at last


def run_cell(folder: Path | str) -> str:
    """Runs the cell in a folder `DIR/cells/NAME` of a sweep, unless it is done, has failed, or another process runs it.

    A cell that was stopped goes on from its last checkpoint. The tables of the sweep are brought up to date.

    Returns:
      how far the cell is then: `done`, `failed`, `running` (elsewhere).
    Raises:
      DiskError, OSError: the disk is full; what was written before stays. ExperimentError: it is no cell of a sweep. NotAllowed: it needs
      code that the caller has not named (`allow_code`).
    """
    path = Path(folder).resolve()
    for cell in cells_of(read_sweep(path.parents[1])):
        if cell.name == path.name:
            cell.require_code()
    return run_cells([path])[0]


def run_cells(folders: Sequence[Path | str], watch: Watch = ALONE) -> list[str]:
    """Runs several cells, as `run_cell` does: those that differ in numbers without shape as one program.

    Args:
      folders: of cells of one sweep.
      watch: how the runs are looked after.
    """
    paths = [Path(folder).resolve() for folder in folders]
    sweep = paths[0].parents[1]
    known = read_sweep(sweep)
    named = {cell.name: cell for cell in cells_of(known)}
    unknown = [path.name for path in paths if path.name not in named or path.parents[1] != sweep]
    if unknown:
        raise ExperimentError(f"{sweep} has no cell {', '.join(unknown)}")
    cells = [named[path.name] for path in paths]
    for cell in cells:
        make_config(cell.config, asked=())  # whoever has cells run names their code
    try:
        with _claimed(sweep, cells, known["episodes"]) as held:
            write_status(sweep, known)
            _run_held(sweep, held, known["episodes"], watch)
    except BaseException:  # also where a user interrupts: nobody runs the cells any more
        with suppress(OSError, ExperimentError):  # the disk may be full
            write_status(sweep, read_sweep(sweep))  # another process may have added cells
        raise
    known = read_sweep(sweep)  # another process may have added cells
    write_tables(sweep, known)
    for one in held:
        _tell_end(sweep, one.cell, known, watch.tell)
    jax.clear_caches()  # compiled programs would fill the memory in the course of a long sweep
    gc.collect()
    return [progress_of(sweep, cell, known["episodes"]).state for cell in cells]


@contextmanager
def _claimed(sweep: Path, cells: Sequence[Cell], episodes: int) -> Iterator[list[Held]]:
    """Yields the cells that are to be run here, claimed; releases them at the end, whatever happens."""
    held: list[Held] = []
    try:
        for cell in cells:
            if progress_of(sweep, cell, episodes).state in (*OVER, "running"):
                continue
            claim = take(sweep, cell.name)
            if claim is not None:
                held.append(Held(cell, claim))
        yield [one for one in held if progress_of(sweep, one.cell, episodes, claimed=True).state not in OVER]  # another may have done it
    finally:
        for one in held:
            one.claim.release()


def _run_held(sweep: Path, held: Sequence[Held], episodes: int, watch: Watch) -> None:
    """Trains claimed cells, side by side where that can be, and evaluates them."""
    waiting = _groups(sweep, held)
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
            record_failure(sweep, group[0].cell, str(error))
        except TakenError as error:
            watch.tell(str(error))
            continue
        except (DiskError, OSError):
            raise
        except Exception as error:  # a reward, a network or a policy of the user's own may raise anything: the other cells go on
            left = [one for one in group if not (diverged_in(run_dir(sweep, one.cell)) or is_finished(run_dir(sweep, one.cell)))]
            if len(group) > 1 and left:
                watch.tell(f"{_said(error)}; so {', '.join(one.cell.name for one in left)} are run one by one")
                waiting[:0] = [[one] for one in left]
            elif left:
                record_failure(sweep, group[0].cell, _said(error))
        for one in group:
            _finish(sweep, one.cell, episodes)


def _said(error: Exception) -> str:
    """Returns what a fault says: of one that is no refusal of ours also its class."""
    return str(error) if isinstance(error, REFUSALS) else f"{type(error).__name__}: {error}"


def _groups(sweep: Path, held: Sequence[Held]) -> list[list[Held]]:
    """Returns cells in groups that one program can run: of one kind, and with a checkpoint of the same update, or without any."""
    groups: list[tuple[Any, set[str], list[Held]]] = []
    for one in held:
        kind = kind_of(environment_of(one.cell), one.cell.configuration())
        saved = {path.name for path in (run_dir(sweep, one.cell) / CHECKPOINTS).glob("*") if path.name.isdecimal()}
        for other, common, members in groups:
            if kind == other and (common & saved or not (common or saved)):
                common &= saved
                members.append(one)
                break
        else:
            groups.append((kind, saved, [one]))
    return [members for _, _, members in groups]


def _train(sweep: Path, group: Sequence[Held], watch: Watch) -> None:
    """Trains the cells of a group that are not finished."""
    open_ = [one for one in group if not is_finished(run_dir(sweep, one.cell)) and not diverged_in(run_dir(sweep, one.cell))]
    if not open_:
        return
    known = read_sweep(sweep)
    runs = []
    for one in open_:
        path = run_dir(sweep, one.cell)
        _clear_half_begun(path)
        asked = {"episodes": known["episodes"]}
        runs.append(Run(environment_of(one.cell), one.cell.configuration(), path, one.cell.provenance, known["loggers"], asked))
        again = ", from its last checkpoint" if (path / MANIFEST).is_file() else ""
        watch.tell(f"{one.cell.name}: training{again}{' side by side' if len(open_) > 1 else ''}")
    train_side_by_side(runs, watch.progress, _callback(open_, watch.stop))


def _callback(held: Sequence[Held], stop: Callable[[], bool]) -> Callable[[Update], bool]:
    """Returns what ends runs that are to end, or whose cell another process has taken over, for this one was suspended."""

    def look(update: Update) -> bool:
        del update
        now = time.time()
        for one in held:
            if now - one.checked > BEAT:
                one.checked = now
                if one.claim.is_lost:
                    raise TakenError(f"{one.cell.name}: another process has taken over, for this one was suspended for long")
        return stop()

    return look


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
    if progress.state == "failed":
        tell(f"{cell.name}: failed, for {progress.reason}")
    elif progress.state == "done":
        returns = collective_returns(sweep, known)[cell.name]
        seeds = f"mean of {len(returns)} seeds" if len(returns) > 1 else "one seed"
        tell(f"{cell.name}: done, collective return {sum(returns) / len(returns):.4g} ({seeds})")
