"""The folder of a sweep: its specification in `sweep.json`, and the progress of each cell."""

import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, PositiveInt, StringConstraints, ValidationError

from sjdsl.experiments.folder import first_difference, read_json
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.files import UNFINISHED
from sjdsl.sweeps.cells import Cell, SweepSpec
from sjdsl.sweeps.locks import is_running
from sjdsl.trainers.json_files import plain, write_json
from sjdsl.trainers.policies.policy_file import POLICIES, SUFFIX
from sjdsl.trainers.policies.stored_evaluation import EVALUATION, StoredEvaluation, read_evaluation
from sjdsl.trainers.runs.checkpoints import last_checkpoint
from sjdsl.trainers.runs.manifest import read_manifest
from sjdsl.trainers.runs.run_errors import RunError
from sjdsl.trainers.runs.run_folder import versions
from sjdsl.trainers.runs.run_state import FINISHED
from sjdsl.trainers.runs.stages import stage_folders
from sjdsl.trainers.runs.updates import describe_divergence
from sjdsl.trainers.settings.config import ConfigError

FORMAT = 1
SWEEP = "sweep.json"
CELLS = "cells"
FAILED = "failed"
State = Literal["waiting", "running", "stopped", "done", "failed"]
# The name of a cell is that of a folder: a path would lead elsewhere.
NAME = Annotated[str, StringConstraints(pattern=r"^\w[\w.+\-]*$", max_length=200)]


class _Sweep(BaseModel):
    """The content of `sweep.json`."""

    model_config = ConfigDict(strict=True, extra="allow")

    format: Literal[1]
    episodes: PositiveInt
    loggers: list[str] = []
    versions: dict[str, str | None]
    cells: dict[NAME, dict[str, Any]]


@dataclass(frozen=True)
class Progress:
    """The progress of a cell."""

    state: State
    update: int = 0  # done
    reason: str = ""  # why it failed

    @property
    def summary(self) -> str:
        """`done`, or `failed: its process was killed`."""
        return f"{self.state}: {self.reason}" if self.reason else self.state


def describe_sweep(spec: SweepSpec, cells: Sequence[Cell]) -> dict[str, Any]:
    """Returns the content of `sweep.json` for a sweep in a new folder."""
    return {
        "format": FORMAT,
        "episodes": spec.episodes,
        "loggers": list(spec.loggers),
        "versions": versions(),
        "cells": {cell.name: cell.described() for cell in cells},
    }


def merge_sweep(folder: Path, wanted: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the new content of `sweep.json`: the wanted sweep added to the stored one.

    Raises:
      ExperimentError: the folder holds something else; nothing in it is changed.
    """
    wanted = plain(wanted)
    if folder.exists() and not folder.is_dir():
        raise ExperimentError(f"{folder} is a file, and a sweep is a folder; name another")
    stored = read_json(folder / SWEEP)
    if stored is None and (folder / SWEEP).exists():
        raise ExperimentError(
            f"{folder / SWEEP} is damaged and can't be read. "
            "Name another folder, or remove this one"
        )
    if stored is None:
        names = []
        if folder.is_dir():
            paths = [path for path in folder.iterdir() if not path.name.endswith(UNFINISHED)]
            names = sorted(path.name for path in paths)
        if names:
            raise ExperimentError(
                f"{folder} is not empty and holds no sweep to resume ({', '.join(names[:3])}); "
                "name another folder"
            )
        return dict(wanted)
    if difference := _difference(stored, wanted):
        raise ExperimentError(
            f"{folder} holds another sweep: {difference}. Ask for other cells with all else as it "
            "was, the games' files included, or name another folder"
        )
    return {**stored, "loggers": wanted["loggers"], "cells": {**stored["cells"], **wanted["cells"]}}


def _difference(stored: Mapping[str, Any], wanted: Mapping[str, Any]) -> str:
    """Returns the first reason why the wanted sweep can't be added to the stored one; empty if
    there is none."""
    if fault := _format_fault(stored):
        return fault
    for key in ("episodes", "versions"):
        if difference := first_difference({key: stored[key]}, {key: wanted[key]}):
            return difference
    for cell in cells_of(stored):
        if cell.name not in wanted["cells"]:
            continue
        old = _without_paths(cell.described())
        new = _without_paths(wanted["cells"][cell.name])
        if difference := first_difference(old, new):
            return f"its cell {cell.name} has {difference}"
    return ""


def _without_paths(described: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the description of a cell without the paths of its game and map, which the hash of
    the rules identifies."""
    provenance = dict(described["provenance"])
    provenance.pop("game", None)
    provenance.pop("map", None)
    earlier = [_without_paths(stage) for stage in described.get("earlier", ())]
    return {**described, "provenance": provenance, "earlier": earlier}


def read_sweep(folder: Path) -> dict[str, Any]:
    """Returns the content of `sweep.json`. Raises ExperimentError if the folder isn't that of a
    sweep.
    """
    content = read_json(folder / SWEEP)
    if content is None:
        raise ExperimentError(f"{folder} is not the folder of a sweep: it has no readable {SWEEP}")
    if fault := _format_fault(content):
        raise ExperimentError(f"{folder} is not the folder of a sweep: {fault}")
    return content


def _format_fault(content: Mapping[str, Any]) -> str:
    """Returns the first fault in the content of a `sweep.json`; empty if there is none."""
    path: tuple[str, ...] = ()
    try:
        _Sweep.model_validate(content)
        for name, described in content["cells"].items():
            path = ("cells", name)
            for stage in Cell.read(name, described).stages:
                stage.configuration()
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(map(str, (*path, *first["loc"])))
        reason = first["msg"]
    except ConfigError as error:
        key = ".".join((*path, "config"))
        reason = str(error)
    else:
        return ""
    return f"the format of its {SWEEP} is not {FORMAT}, for in `{key}`: {reason}"


def write_sweep(folder: Path, wanted: Mapping[str, Any]) -> dict[str, Any]:
    """Adds the wanted sweep to `sweep.json`, which is written only if that changes it; returns its
    content.
    """
    content = merge_sweep(folder, wanted)
    folder.mkdir(parents=True, exist_ok=True)
    if content != read_json(folder / SWEEP):
        write_json(folder / SWEEP, content)
    (folder / CELLS).mkdir(exist_ok=True)
    return content


def cells_of(content: Mapping[str, Any]) -> list[Cell]:
    """Returns the cells of a `sweep.json`, in their order."""
    return [Cell.read(name, described) for name, described in content["cells"].items()]


def cell_at(folder: Path | str) -> tuple[Path, dict[str, Any], Cell]:
    """Returns the folder of a sweep, the content of its `sweep.json`, and the cell in a folder
    `DIR/cells/NAME`.

    Raises:
      ExperimentError: it isn't the folder of a cell of a sweep.
    """
    path = Path(folder).resolve()
    sweep = path.parents[1]
    content = read_sweep(sweep)
    cell = next((cell for cell in cells_of(content) if run_dir(sweep, cell) == path), None)
    if cell is None:
        raise ExperimentError(f"{sweep} has no cell {path.name}")
    return sweep, content, cell


def run_dir(folder: Path, cell: Cell) -> Path:
    """Returns the folder of a cell's run."""
    return folder / CELLS / cell.name


def progress_of(folder: Path, cell: Cell, episodes: int) -> Progress:
    """Returns the progress of a cell, from its files and its lock.

    Args:
      episodes: of its evaluation.
    """
    path = run_dir(folder, cell)
    update = max(manifest_of(path).get("updates", 0), last_checkpoint(path))
    failed = read_json(folder / FAILED / f"{cell.name}.json")
    if failed is not None:
        return Progress("failed", update, reason=str(failed.get("reason", "")))
    if is_done(folder, cell, episodes):
        return Progress("done", update)
    if is_running(folder, cell.name):
        return Progress("running", update)
    has_begun = path.is_dir() and any(path.iterdir())
    return Progress("stopped" if has_begun else "waiting", update)


def manifest_of(path: Path) -> dict[str, Any]:
    """Returns the manifest of a run, or an empty one if it can't be read."""
    try:
        return read_manifest(path)
    except RunError:
        return {}


def is_finished(path: Path) -> bool:
    """Whether a run has done all its updates, with every seed."""
    manifest = manifest_of(path)
    return manifest.get("status") == FINISHED and not manifest.get("diverged")


def is_done(folder: Path, cell: Cell, episodes: int) -> bool:
    """Whether a cell's run is finished, with every seed, and each is evaluated."""
    path = run_dir(folder, cell)
    if not is_finished(path):
        return False
    return all(
        evaluation_of(seed_dir, seed, episodes) is not None
        for seed, seed_dir in seed_dirs(path, cell).items()
    )


def evaluation_of(path: Path, seed: int, episodes: int) -> StoredEvaluation | None:
    """Returns the evaluation of a seed's last policy from which the sweep reads its results.

    None if it is missing, damaged, or replaced by another: `sjdsl evaluate` writes the same file,
    with other seeds or episodes.
    """
    evaluation = read_evaluation(path / EVALUATION)
    if evaluation is None or evaluation.policy != "last" or evaluation.greedy is not None:
        return None
    is_same = evaluation.seed == seed and evaluation.episodes == episodes
    return evaluation if is_same else None


def seed_dirs(path: Path, cell: Cell) -> dict[int, Path]:
    """Returns the folder of each seed of a cell's run."""
    if len(cell.seeds) == 1:
        return {cell.seeds[0]: path}
    return {seed: path / f"seed_{seed}" for seed in cell.seeds}


def diverged_in(path: Path) -> str:
    """Returns in words which seeds of a run diverged, and when, in any stage; empty if none did."""
    updates = {}
    for folder in stage_folders(path):
        for entry in manifest_of(folder).get("diverged", ()):
            updates[entry["seed"]] = entry["update"]
    return describe_divergence(updates)


def record_failure(folder: Path, cell: Cell, reason: str) -> None:
    """Records why a cell failed; it isn't run again until `retry`."""
    (folder / FAILED).mkdir(exist_ok=True)
    at = datetime.now(UTC).isoformat(timespec="seconds")
    write_json(folder / FAILED / f"{cell.name}.json", {"reason": reason, "at": at})


def retry(folder: Path, cell: Cell) -> None:
    """Lets a failed cell run again from its last checkpoint, or from the start if none could help.

    None helps if a loss wasn't finite, the manifest can't be read, or the run finished and the last
    policy of a seed is lost. Then the old files are moved aside.
    """
    path = run_dir(folder, cell)
    manifest = manifest_of(path)
    last_policies = [
        seed_dir / POLICIES / f"last{SUFFIX}" for seed_dir in seed_dirs(path, cell).values()
    ]
    lacks_policy = not all(policy.is_file() for policy in last_policies)
    is_lost = manifest.get("status") == FINISHED and lacks_policy
    if path.is_dir() and (not manifest or diverged_in(path) or is_lost):
        number = 1
        while (aside := folder / FAILED / f"{cell.name}_{number}").exists():
            number += 1
        shutil.move(path, aside)
    (folder / FAILED / f"{cell.name}.json").unlink(missing_ok=True)


def steps_of(cell: Cell) -> int:
    """Returns the environment steps of each seed of a cell in all stages, rounded up to whole
    updates.
    """
    return sum(stage.steps for stage in cell.stages)


def as_text(value: Any) -> str:
    """Returns a value of an axis as text for tables."""
    if isinstance(value, list):
        return ";".join(map(as_text, value))
    if isinstance(value, Mapping):
        return json.dumps(value)
    if isinstance(value, float):
        return f"{value:g}"
    return "" if value is None else str(value)
