"""The folder of an experiment: what was asked, and a part for each line-up that has been played, so that a stopped command goes on."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sjdsl.experiments.refusals import ExperimentError
from sjdsl.trainers.evaluation import Evaluation
from sjdsl.trainers.run_files import plain, write_json

ASKED = "experiment.json"
PARTS = "parts"
ARRAYS = ("returns", "lengths", "order")


class Folder:
    """A folder with what was asked in `experiment.json`, and in `parts` a file a line-up and replicate, each whole or not there."""

    def __init__(self, path: Path, asked: Mapping[str, Any]) -> None:
        """Makes the folder, or goes on with the experiment in it.

        Args:
          path: a new or empty folder, or one of the same experiment.
          asked: all that the results depend on, as JSON values.
        Raises:
          ExperimentError: there is something else in it.
        """
        self.path = path
        wanted = plain(asked)
        if path.exists() and not path.is_dir():
            raise ExperimentError(f"{path} is a file, and the results are a folder; name another")
        before = _read(path / ASKED)
        if before is None:
            others = sorted(inside.name for inside in path.iterdir() if inside.name != f"{ASKED}.unfinished") if path.is_dir() else []
            if others:
                raise ExperimentError(
                    f"{path} is not empty and holds no experiment to go on with ({', '.join(others[:3])}); name another folder"
                )
            path.mkdir(parents=True, exist_ok=True)
            write_json(path / ASKED, wanted)
        elif before != wanted:
            raise ExperimentError(f"{path} holds another experiment: {'; '.join(_differences(before, wanted))}. Name another folder")
        (path / PARTS).mkdir(exist_ok=True)

    def find(self, name: str) -> tuple[Evaluation, np.ndarray] | None:
        """Returns what was played, and the order of its slots; None where it was not, or cannot be read."""
        found = _read(self.path / PARTS / f"{name}.json")
        if found is None or not all(isinstance(found.get(key), list) for key in ARRAYS):
            return None
        events = {event: np.asarray(counts, np.int32) for event, counts in found.get("events", {}).items()}
        played = Evaluation(np.asarray(found["returns"], np.float32), np.asarray(found["lengths"], np.int32), events, {}, {})
        return played, np.asarray(found["order"], np.int32)

    def keep(self, name: str, played: Evaluation, order: np.ndarray) -> None:
        """Writes what was played. Raises OSError when there is no room; then nothing of it is there."""
        content = {"returns": played.returns, "lengths": played.lengths, "events": dict(played.events), "order": order}
        write_json(self.path / PARTS / f"{name}.json", content)


def _read(path: Path) -> dict[str, Any] | None:
    """Returns what a JSON file holds; None if it is not there or is none."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) else None


def _differences(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    """Returns what two experiments do not have alike, a phrase each."""
    for key in sorted(before.keys() | now.keys()):
        there, here = before.get(key), now.get(key)
        if there == here:
            continue
        if isinstance(there, Mapping) and isinstance(here, Mapping):
            yield from (f"{key} {phrase}" for phrase in _differences(there, here))
        elif isinstance(there, list | Mapping) or isinstance(here, list | Mapping):
            yield f"its {key} are others"
        else:
            yield f"{key} {there} there, {here} here"
