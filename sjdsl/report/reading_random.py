"""Reads what a random policy earns in the bundled games, as `sjdsl doc --all` has measured it."""

from pathlib import Path

from sjdsl.files import read_json
from sjdsl.report.evidence import Evidence, RandomRow
from sjdsl.report.refusals import ReportError

RETURN = "return, summed over agents"  # its name in the file


def is_random(path: Path) -> bool:
    """Returns whether a file is the one that `sjdsl doc --all` keeps its figures in."""
    try:
        stored = read_json(path) if path.suffix == ".json" else None
    except (OSError, ValueError):
        return False
    return isinstance(stored, dict) and any(isinstance(entry, dict) and RETURN in entry.get("values", ()) for entry in stored.values())


def read_random(path: Path) -> Evidence:
    """Returns the returns of a random policy by game. Raises ReportError for a file that cannot be read."""
    try:
        stored = read_json(path)
        rows = []
        for game, entry in stored.items():
            figure = entry["values"][RETURN]
            rows.append(RandomRow(game, entry["hash"], figure["mean"], figure["low"], figure["high"], entry["episodes"]))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ReportError(f"{path} cannot be read ({type(error).__name__}: {error})") from None
    return Evidence(random=tuple(rows))
