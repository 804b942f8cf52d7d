"""Runs cells: however many processes call `run_cell` on a folder, on any machine, the cell runs
once, and resumes if it was stopped."""

import gc
import json
import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import jax
import numpy as np

import sjdsl
from sjdsl.experiments.players import acting_config
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.files import UNFINISHED
from sjdsl.library.stored_game import GameMoved, locate_game
from sjdsl.sweeps.cells import Cell, CellStage
from sjdsl.sweeps.folder import (
    cell_at,
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
from sjdsl.sweeps.locks import take_lock
from sjdsl.sweeps.tables import results, write_results
from sjdsl.trainers.policies.evaluation import (
    Evaluation,
    evaluation_key,
    make_evaluator,
    save_evaluation,
)
from sjdsl.trainers.policies.loading import PolicyError, read_parameters, trained_policy
from sjdsl.trainers.policies.policy_file import START, policy_path
from sjdsl.trainers.policies.stored_evaluation import EVALUATION
from sjdsl.trainers.runs.checkpoints import last_checkpoint, resumption
from sjdsl.trainers.runs.manifest import MANIFEST
from sjdsl.trainers.runs.progress import ProgressStyle
from sjdsl.trainers.runs.run import Stage, resume, train
from sjdsl.trainers.runs.run_errors import DiskError, RunError
from sjdsl.trainers.runs.run_lock import LOCK
from sjdsl.trainers.settings.config import ConfigError, make_config, stored_config
from sjdsl.trainers.settings.stage_settings import STAGES

Tell = Callable[[str], None]
REFUSALS = (RunError, ConfigError, PolicyError, ExperimentError)
OVER = ("done", "failed")  # states of cells that don't run again


@dataclass(frozen=True)
class Watch:
    """How to show the progress of runs."""

    progress: ProgressStyle = "none"
    tell: Tell = lambda _: None


SILENT = Watch()


def run_cell(folder: Path | str, watch: Watch = SILENT) -> str:
    """Runs the cell in a folder `DIR/cells/NAME` of a sweep, unless it is done, has failed, or is
    running in another process.

    A cell that was stopped resumes from its last checkpoint. The table of the sweep is updated.

    Returns:
      the cell's state afterwards: `done`, `failed`, or `running` (elsewhere).
    Raises:
      DiskError, OSError: the disk is full; the files written before stay.
      ExperimentError: the folder isn't a cell of a sweep.
      NotAllowed: the cell needs code that the caller hasn't allowed (`allow_code`).
    """
    sweep, content, cell = cell_at(folder)
    cell.require_code()
    for stage in cell.stages:
        make_config(stage.config, asked=())  # imports the code that it names
    episodes = content["episodes"]
    has_run = False
    if progress_of(sweep, cell, episodes).state not in OVER:
        lock = take_lock(sweep, cell.name)
        if lock is not None:
            try:
                # Another process may have finished the cell before this one had the lock.
                if progress_of(sweep, cell, episodes).state not in OVER:
                    has_run = True
                    _train_and_evaluate(sweep, cell, content, watch)
            finally:
                lock.release()
    content = read_sweep(sweep)  # another process may have added cells
    write_results(sweep, content)
    progress = progress_of(sweep, cell, episodes)
    if has_run and progress.state == "done":
        rows = [row for row in results(sweep, content) if row["cell"] == cell.name]
        returns = [float(row["collective_return"]) for row in rows]
        seeds = f"mean of {len(returns)} seeds" if len(returns) > 1 else "one seed"
        watch.tell(f"{cell.name}: done, collective return {np.mean(returns):.4g} ({seeds})")
    elif has_run and progress.state == "failed":
        watch.tell(f"{cell.name}: {progress.summary}")
    jax.clear_caches()  # in a long sweep, compiled programs would fill the memory
    gc.collect()
    return progress.state


def _train_and_evaluate(sweep: Path, cell: Cell, content: Mapping[str, Any], watch: Watch) -> None:
    """Trains and evaluates a cell that this process has locked; records why it failed.

    content: of `sweep.json`.
    """
    arguments_now(sweep, cell)  # raises if the game has moved, which is no failure of the cell
    try:
        if _can_continue(sweep, cell):
            _train(sweep, cell, content, watch)
    except (DiskError, OSError):
        raise
    except Exception as error:
        # The user's own code may raise anything; the other cells continue.
        if _can_continue(sweep, cell):
            reason = str(error)
            if not isinstance(error, REFUSALS):
                reason = f"{type(error).__name__}: {error}"
            record_failure(sweep, cell, reason)
    _finish(sweep, cell, content["episodes"])


def _can_continue(sweep: Path, cell: Cell) -> bool:
    """Whether the run of a cell has updates left, and can continue."""
    path = run_dir(sweep, cell)
    return not is_finished(path) and not diverged_in(path)


def _train(sweep: Path, cell: Cell, content: Mapping[str, Any], watch: Watch) -> None:
    """Trains a cell, from its last checkpoint if it has begun."""
    path = run_dir(sweep, cell)
    *earlier, last = stages_of(cell, sweep)
    _remove_unstarted(path)
    if (path / MANIFEST).is_file():
        watch.tell(f"{cell.name}: training, {resumption(last_checkpoint(path))}")
        resume(
            last.env,
            path,
            watch.progress,
            provenance=last.provenance,
            earlier=[stage.env for stage in earlier],
        )
    else:
        watch.tell(f"{cell.name}: training")
        train(
            last.env,
            last.config,
            path,
            watch.progress,
            provenance=last.provenance,
            loggers=content["loggers"],
            asked={"episodes": content["episodes"]},
            earlier=earlier,
        )


def _remove_unstarted(path: Path) -> None:
    """Removes the files of a run that was stopped before it wrote its manifest: the policy that it
    starts with, its stages and its lock.

    Raises ExperimentError if there are other files; they stay.
    """
    if not path.is_dir() or (path / MANIFEST).is_file():
        return
    names = sorted(file.name for file in path.iterdir())
    written_first = {START, str(Path(START).with_suffix(".json")), MANIFEST, LOCK, STAGES}
    others = [name for name in names if name not in written_first and not name.endswith(UNFINISHED)]
    if others:
        raise ExperimentError(
            f"{path} holds {', '.join(others[:3])} but no {MANIFEST}; "
            "--retry moves it aside and starts again"
        )
    shutil.rmtree(path / STAGES, ignore_errors=True)
    for name in names:
        (path / name).unlink(missing_ok=True)


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
        evaluate_cell(sweep, cell, episodes)
    except REFUSALS as error:
        record_failure(sweep, cell, str(error))


def evaluate_cell(sweep: Path, cell: Cell, episodes: int) -> None:
    """Plays episodes with the last policy of each seed, and writes `evaluation.json` as `sjdsl
    train` does; seeds that have one are skipped.

    Raises:
      PolicyError: a policy can't be read. ExperimentError: a return is not finite.
    """
    path = run_dir(sweep, cell)
    env = environment_of(cell, sweep)
    arguments = json.dumps(arguments_now(sweep, cell), sort_keys=True)
    config = stored_config(manifest_of(path).get("config", cell.config))
    for seed, seed_dir in seed_dirs(path, cell).items():
        if evaluation_of(seed_dir, seed, episodes) is not None:
            continue
        evaluate = _evaluator(arguments, acting_config(config), episodes)
        parameters, description = read_parameters(policy_path(seed_dir, "last"), env)
        evaluation = evaluate(evaluation_key(seed), parameters)
        if not np.isfinite(evaluation.returns).all():
            raise ExperimentError(
                f"the returns of the last policy of seed {seed} are not finite, "
                "so they have no mean"
            )
        about = {"policy": "last", "update": description.update, "seed": seed, "greedy": None}
        save_evaluation(evaluation, seed_dir / EVALUATION, about)


@lru_cache(maxsize=4)
def _evaluator(
    arguments_json: str, config_json: str, episodes: int
) -> Callable[[Any, Any], Evaluation]:
    """Returns an evaluator of policies with one network in one game, compiled once for all seeds
    and cells that share them.

    Args:
      arguments_json: of `sjdsl.make`; JSON, because `lru_cache` hashes its arguments.
      config_json: the settings that decide how a policy acts, as `acting_config` returns them.
    """
    env = _environment(arguments_json)
    config = stored_config(json.loads(config_json))
    return make_evaluator(env, lambda parameters: trained_policy(env, config, parameters), episodes)


def stages_of(cell: Cell, sweep: Path) -> list[Stage]:
    """Returns the stages of a cell of the sweep in a folder. Raises what `environment_of` does."""
    return [
        Stage(environment_of(stage, sweep), stage.configuration(), arguments_now(sweep, stage))
        for stage in cell.stages
    ]


def arguments_now(sweep: Path, cell: CellStage) -> dict[str, Any]:
    """Returns the arguments of a cell's environment, with the paths that its game and map have now.

    Raises:
      ExperimentError: a file is gone.
    """
    try:
        return locate_game(cell.provenance, cell.hash, sweep)
    except GameMoved as error:
        raise ExperimentError(
            f"{error}; run the sweep's command again with the path that the game has now"
        ) from None


def environment_of(cell: CellStage, sweep: Path) -> Any:
    """Returns the environment of a cell of the sweep in a folder.

    Raises:
      ExperimentError: its rules have changed since the sweep began, or a file is gone.
    """
    env = _environment(json.dumps(arguments_now(sweep, cell), sort_keys=True))
    if env.hash != cell.hash:
        raise ExperimentError(
            f"the rules of {env.name} have changed since the sweep began: {cell.hash} then, "
            f"{env.hash} now; restore the file, or start another sweep"
        )
    return env


@lru_cache(maxsize=32)
def _environment(arguments_json: str) -> Any:
    """Returns the environment of these arguments of `sjdsl.make`, made once."""
    arguments: Mapping[str, Any] = json.loads(arguments_json)
    return sjdsl.make(**arguments)
