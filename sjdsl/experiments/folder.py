"""The folder of an experiment: `experiment.json` says what its results depend on, so that no other experiment overwrites them."""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sjdsl import files
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.files import UNFINISHED, write_whole
from sjdsl.trainers.json_files import plain, write_json

ASKED = "experiment.json"
DIAGRAM, CROSS_PLAY = "schelling.json", "crossplay.json"
RESULTS = (DIAGRAM, CROSS_PLAY)  # the last file of an experiment
INNERMOST_LIST = re.compile(r"\[\n\s*([^\[\]{}]*?)\n\s*\]")  # JSON strings contain no line breaks


def require_same(path: Path, asked: Mapping[str, Any]) -> None:
    """Checks that an experiment may write its results to a folder: it is new, empty, of the same experiment, or of one without results.

    Args:
      asked: everything that the results depend on, as JSON values.
    Raises:
      ExperimentError: it holds something else.
    """
    if path.exists() and not path.is_dir():
        raise ExperimentError(f"{path} is a file, but the results need a folder; name another")
    before, wanted = read_json(path / ASKED), plain(asked)
    if before is not None and before != wanted and _has_results(path):
        raise ExperimentError(
            f"{path} holds another experiment: {first_difference(before, wanted)}. Name another folder"
        )
    inside = (
        sorted(found.name for found in path.iterdir() if not found.name.endswith(UNFINISHED))
        if path.is_dir()
        else []
    )
    if inside == [ASKED] and not _has_results(path):
        return
    if before is None and (path / ASKED).exists():
        raise ExperimentError(
            f"{path / ASKED} is damaged and can't be read. Name another folder, or remove this one"
        )
    if before is None and inside:
        raise ExperimentError(
            f"{path} is not empty and holds no experiment ({', '.join(inside[:3])}); name another folder"
        )


def _has_results(path: Path) -> bool:
    """Whether an experiment has written its last file to a folder, or, for scenarios, beside it; one that was killed hasn't."""
    return any(
        file.exists()
        for file in (*(path / name for name in RESULTS), path.with_name(f"{path.name}.json"))
    )


def record_experiment(path: Path, asked: Mapping[str, Any]) -> None:
    """Writes what the results in a folder depend on, before they are written themselves."""
    path.mkdir(parents=True, exist_ok=True)
    write_json(path / ASKED, asked)


def read_json(path: Path) -> dict[str, Any] | None:
    """Returns the object in a JSON file; None if the file is missing or holds no object."""
    try:
        found = files.read_json(path)
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) else None


def first_difference(before: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    """Returns the first key that differs, with both values unless they are lists, which come last; empty if none does."""
    for key in sorted(
        before.keys() | now.keys(),
        key=lambda key: (isinstance(before.get(key, now.get(key)), list), key),
    ):
        there, here = before.get(key), now.get(key)
        if isinstance(there, Mapping) and isinstance(here, Mapping):
            if found := first_difference(there, here):
                return f"{key} {found}"
        elif there != here:
            is_long = isinstance(there, list | Mapping) or isinstance(here, list | Mapping)
            return f"its {key} differ" if is_long else f"{key} {there} there, {here} here"
    return ""


def write_compact_json(path: Path, content: Mapping[str, Any]) -> None:
    """Writes an indented JSON file with each innermost list on one line, atomically; non-finite numbers become null."""
    text = json.dumps(plain(content), indent=1, allow_nan=False)
    text = INNERMOST_LIST.sub(lambda found: "[" + re.sub(r",\n\s*", ", ", found[1]) + "]", text)
    write_whole(path, f"{text}\n".encode())
