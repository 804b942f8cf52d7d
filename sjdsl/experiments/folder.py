"""The folder of an experiment: `experiment.json` holds all that its results depend on, so that no
other experiment overwrites them."""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sjdsl import files
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.files import UNFINISHED, write_whole
from sjdsl.models.recorded import FOLDER as TALKS
from sjdsl.models.recorded import UNANSWERED
from sjdsl.trainers.json_files import plain, write_json

DESCRIPTION = "experiment.json"
DIAGRAM = "schelling.json"
CROSS_PLAY = "crossplay.json"
INNERMOST_LIST = re.compile(r"\[\n\s*([^\[\]{}]*?)\n\s*\]")  # JSON strings contain no line breaks


def require_same(path: Path, description: Mapping[str, Any]) -> None:
    """Checks that an experiment may write its results to a folder.

    It may if the folder is new, empty, of the same experiment, or of one without results.

    Args:
      description: everything that the results depend on, as JSON values.
    Raises:
      ExperimentError: the folder holds something else.
    """
    if path.exists() and not path.is_dir():
        raise ExperimentError(f"{path} is a file, but the results need a folder; name another")
    stored = read_json(path / DESCRIPTION)
    description = plain(description)
    if stored is not None and stored != description and _has_results(path):
        raise ExperimentError(
            f"{path} holds another experiment: {first_difference(stored, description)}. "
            "Name another folder"
        )
    names = []
    if path.is_dir():
        names = sorted(file.name for file in path.iterdir() if not file.name.endswith(UNFINISHED))
    if names == [DESCRIPTION] and not _has_results(path):
        return
    if stored is None and (path / DESCRIPTION).exists():
        raise ExperimentError(
            f"{path / DESCRIPTION} is damaged and can't be read. "
            "Name another folder, or remove this one"
        )
    if stored is None and names:
        raise ExperimentError(
            f"{path} is not empty and holds no experiment ({', '.join(names[:3])}); "
            "name another folder"
        )


def _has_results(path: Path) -> bool:
    """Whether an experiment has written its last file, which is in its folder; for scenarios,
    beside it; or has asked models, which may have cost money."""
    last_files = (path / DIAGRAM, path / CROSS_PLAY, path.with_name(f"{path.name}.json"))
    calls = [*(path / TALKS).rglob("*.jsonl"), *(path / TALKS).glob(UNANSWERED)]
    return any(file.exists() for file in (*last_files, *calls))


def record_experiment(path: Path, description: Mapping[str, Any]) -> None:
    """Writes what the results in a folder depend on, before they are written themselves."""
    path.mkdir(parents=True, exist_ok=True)
    write_json(path / DESCRIPTION, description)


def read_json(path: Path) -> dict[str, Any] | None:
    """Returns the object in a JSON file; None if the file is missing or holds no object."""
    try:
        content = files.read_json(path)
    except (OSError, ValueError):
        return None
    return content if isinstance(content, dict) else None


def first_difference(stored: Mapping[str, Any], current: Mapping[str, Any]) -> str:
    """Returns the first key whose values differ, with both values; empty if there is none.

    Keys of lists come last, and the lists themselves are not in the text.
    """

    def order(key: str) -> tuple[bool, str]:
        return isinstance(stored.get(key, current.get(key)), list), key

    for key in sorted(stored.keys() | current.keys(), key=order):
        old = stored.get(key)
        new = current.get(key)
        if isinstance(old, Mapping) and isinstance(new, Mapping):
            if difference := first_difference(old, new):
                return f"{key} {difference}"
        elif old != new:
            is_long = isinstance(old, list | Mapping) or isinstance(new, list | Mapping)
            return f"its {key} differ" if is_long else f"{key} {old} there, {new} here"
    return ""


def write_compact_json(path: Path, content: Mapping[str, Any]) -> None:
    """Writes an indented JSON file with each innermost list on one line, atomically.

    Non-finite numbers become null.
    """
    text = json.dumps(plain(content), indent=1, allow_nan=False)
    text = INNERMOST_LIST.sub(lambda match: "[" + re.sub(r",\n\s*", ", ", match[1]) + "]", text)
    write_whole(path, f"{text}\n".encode())
