"""The folder of an experiment: what was asked, and a part for each line-up that has been played, so that a stopped command goes on."""

import fcntl
import os
import socket
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from sjdsl import files
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.files import UNFINISHED, naming, open_in_place
from sjdsl.trainers.evaluation import Evaluation
from sjdsl.trainers.run_files import plain, write_json

ASKED = "experiment.json"
PARTS = "parts"
LOCK = ".lock"  # in it: who plays
ARRAYS = ("returns", "lengths", "order")


class Folder:
    """A folder with what was asked in `experiment.json`, and in `parts` a file a line-up and replicate, each whole or not there."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def find(self, name: str) -> tuple[Evaluation, np.ndarray] | None:
        """Returns what was played, and the order of its slots; None where it was not, or cannot be read."""
        found = read_json(self.path / PARTS / f"{name}.json")
        if found is None or not all(isinstance(found.get(key), list) for key in ARRAYS):
            return None
        try:
            events = {event: np.asarray(counts, np.int32) for event, counts in found.get("events", {}).items()}
            played = Evaluation(np.asarray(found["returns"], np.float32), np.asarray(found["lengths"], np.int32), events, {}, {})
            return played, np.asarray(found["order"], np.int32)
        except (TypeError, ValueError):  # not of numbers, or not of one shape
            return None

    def keep(self, name: str, played: Evaluation, order: np.ndarray) -> None:
        """Writes what was played. Raises OSError when there is no room; then nothing of it is there."""
        content = {"returns": played.returns, "lengths": played.lengths, "events": dict(played.events), "order": order}
        write_json(self.path / PARTS / f"{name}.json", content)


@contextmanager
def open_folder(path: Path | None, asked: Mapping[str, Any]) -> Iterator[Folder | None]:
    """Makes a folder, or goes on with the experiment in it; until the block ends no other process can.

    Args:
      path: a new or empty folder, or one of the same experiment; None keeps nothing.
      asked: all that the results depend on, as JSON values.
    Raises:
      ExperimentError: there is something else in it, or another process has it.
    """
    if path is None:
        yield None
        return
    wanted = plain(asked)
    _check_same(path, wanted)
    (path / PARTS).mkdir(parents=True, exist_ok=True)
    with naming(path / PARTS / LOCK), open_in_place(path / PARTS / LOCK, "a+") as lock:
        _lock(lock, path)
        if not _check_same(path, wanted):  # once more: another process may have begun in between
            write_json(path / ASKED, wanted)
        yield Folder(path)


def _lock(lock: TextIO, path: Path) -> None:
    """Takes the lock, which the system gives back when this process ends, however it ends. Raises ExperimentError where another has it."""
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        lock.seek(0)
        holder = lock.read().strip() or "another process"
        raise ExperimentError(f"{path} is in use: {holder} is playing in it now; wait until it has ended, or name another folder") from None
    lock.truncate(0)
    lock.write(f"process {os.getpid()} on {socket.gethostname()}\n")
    lock.flush()


def _check_same(path: Path, wanted: Mapping[str, Any]) -> bool:
    """Returns whether a folder holds this experiment, rather than none. Raises ExperimentError where it holds something else."""
    if path.exists() and not path.is_dir():
        raise ExperimentError(f"{path} is a file, and the results are a folder; name another")
    before = read_json(path / ASKED)
    if before is not None:
        if before != wanted:
            if not _foreign(path):
                return False  # it ended before its first line-up was played: nothing is lost
            raise ExperimentError(f"{path} holds another experiment: {'; '.join(differences(before, wanted))}. Name another folder")
        return True
    if (path / ASKED).exists():
        raise ExperimentError(f"{path / ASKED} is damaged: what was asked there cannot be read. Name another folder, or remove this one")
    others = _foreign(path) if path.is_dir() else []
    if others:
        raise ExperimentError(f"{path} is not empty and holds no experiment to go on with ({', '.join(others[:3])}); name another folder")
    return False


def _foreign(path: Path) -> list[str]:
    """Returns what a folder holds besides what one is begun with, before anything is played."""
    begun = {ASKED, PARTS}
    others = sorted(inside.name for inside in path.iterdir() if inside.name not in begun and not inside.name.endswith(UNFINISHED))
    played = sorted(f"{PARTS}/{inside.name}" for inside in (path / PARTS).glob("*") if inside.name != LOCK)
    return others + played


def read_json(path: Path) -> dict[str, Any] | None:
    """Returns what a JSON file holds; None if it is not there or is none."""
    try:
        found = files.read_json(path)
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) else None


def differences(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    """Returns what two experiments do not have alike, a phrase each."""
    for key in sorted(before.keys() | now.keys()):
        there, here = before.get(key), now.get(key)
        if there == here:
            continue
        if isinstance(there, Mapping) and isinstance(here, Mapping):
            yield from (f"{key} {phrase}" for phrase in differences(there, here))
        elif isinstance(there, list | Mapping) or isinstance(here, list | Mapping):
            yield f"its {key} are others"
        else:
            yield f"{key} {there} there, {here} here"
