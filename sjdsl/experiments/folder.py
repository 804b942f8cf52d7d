"""The folder of an experiment: its settings, and a part for each line-up that has been played, so that a stopped command can resume."""

import json
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from sjdsl import files
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.files import UNFINISHED, naming, write_whole
from sjdsl.trainers.evaluation import Evaluation
from sjdsl.trainers.run_files import plain, write_json
from sjdsl.trainers.run_lock import LOCK, locked

ASKED = "experiment.json"
PARTS = "parts"
ARRAYS = ("returns", "lengths", "order")
INNERMOST_LIST = re.compile(r"\[\n\s*([^\[\]{}]*?)\n\s*\]")  # JSON strings contain no line breaks


class Folder:
    """A folder with the settings in `experiment.json`, and in `parts` one file for each line-up and replicate, written atomically."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def find(self, name: str) -> tuple[Evaluation, np.ndarray] | None:
        """Returns the episodes that were played and the order of their slots; None if there are none, or they can't be read."""
        found = read_json(self.path / PARTS / f"{name}.json")
        if found is None or not all(isinstance(found.get(key), list) for key in ARRAYS):
            return None
        try:
            events = {event: np.asarray(counts, np.int32) for event, counts in found.get("events", {}).items()}
            played = Evaluation(np.asarray(found["returns"], np.float32), np.asarray(found["lengths"], np.int32), events, {}, {})
            return played, np.asarray(found["order"], np.int32)
        except (TypeError, ValueError):  # not numbers, or not of one shape
            return None

    def keep(self, name: str, played: Evaluation, order: np.ndarray) -> None:
        """Stores the episodes. Raises OSError if the disk is full; then nothing of them is stored."""
        content = {"returns": played.returns, "lengths": played.lengths, "events": dict(played.events), "order": order}
        write_json(self.path / PARTS / f"{name}.json", content)


@contextmanager
def open_folder(path: Path | None, asked: Mapping[str, Any]) -> Iterator[Folder | None]:
    """Makes a folder, or resumes the experiment in it; no other process can use it until the block ends.

    Args:
      path: a new or empty folder, or one of the same experiment; None stores nothing.
      asked: everything that the results depend on, as JSON values.
    Raises:
      ExperimentError: the folder holds something else, or another process is using it.
    """
    if path is None:
        yield None
        return
    wanted = plain(asked)
    _check_same(path, wanted)
    in_use = "{} is in use by {}; wait until it has ended, or name another folder"
    with naming(path / PARTS / LOCK), locked(path / PARTS, lambda holder: ExperimentError(in_use.format(path, holder))):
        if not _check_same(path, wanted):  # again: another process may have started in between
            write_json(path / ASKED, wanted)
        yield Folder(path)


def _check_same(path: Path, wanted: Mapping[str, Any]) -> bool:
    """Returns whether a folder holds this experiment; False if it is empty. Raises ExperimentError if it holds something else."""
    if path.exists() and not path.is_dir():
        raise ExperimentError(f"{path} is a file, but the results need a folder; name another")
    before = read_json(path / ASKED)
    if before is not None:
        if before != wanted:
            if not _foreign(path):
                return False  # stopped before its first line-up was played: nothing is lost
            raise ExperimentError(f"{path} holds another experiment: {'; '.join(differences(before, wanted))}. Name another folder")
        return True
    if (path / ASKED).exists():
        raise ExperimentError(f"{path / ASKED} is damaged and can't be read. Name another folder, or remove this one")
    others = _foreign(path) if path.is_dir() else []
    if others:
        raise ExperimentError(f"{path} is not empty and holds no experiment to resume ({', '.join(others[:3])}); name another folder")
    return False


def _foreign(path: Path) -> list[str]:
    """Returns what a folder holds besides the files that every experiment starts with."""
    others = sorted(inside.name for inside in path.iterdir() if inside.name not in (ASKED, PARTS) and not inside.name.endswith(UNFINISHED))
    played = sorted(f"{PARTS}/{inside.name}" for inside in (path / PARTS).glob("*") if inside.name != LOCK)
    return others + played


def read_json(path: Path) -> dict[str, Any] | None:
    """Returns the object in a JSON file; None if the file is missing or holds no object."""
    try:
        found = files.read_json(path)
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) else None


def differences(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    """Yields the differences between two experiments, one phrase each."""
    for key in sorted(before.keys() | now.keys()):
        there, here = before.get(key), now.get(key)
        if there == here:
            continue
        if isinstance(there, Mapping) and isinstance(here, Mapping):
            yield from (f"{key} {phrase}" for phrase in differences(there, here))
        elif isinstance(there, list | Mapping) or isinstance(here, list | Mapping):
            yield f"its {key} differ"
        else:
            yield f"{key} {there} there, {here} here"


def write_compact_json(path: Path, content: Mapping[str, Any]) -> None:
    """Writes an indented JSON file with each innermost list on one line, atomically; non-finite numbers become null."""
    text = json.dumps(plain(content), indent=1, allow_nan=False)
    text = INNERMOST_LIST.sub(lambda found: "[" + re.sub(r",\n\s*", ", ", found[1]) + "]", text)
    write_whole(path, f"{text}\n".encode())
