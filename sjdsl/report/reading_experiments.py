"""Reads the folders of experiments with policies: Schelling diagrams and cross-play."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sjdsl.experiments.bundled_rules import other_numbers
from sjdsl.files import read_json
from sjdsl.report.evidence import DiagramRow, Evidence, Meeting, RandomRow, rounded
from sjdsl.report.refusals import ReportError

ASKED, DIAGRAM, CROSS_PLAY = "experiment.json", "schelling.json", "crossplay.json"
FORMAT = 1


def is_diagram(path: Path) -> bool:
    """Returns whether a folder is that of a Schelling diagram, or of one that was begun."""
    return (path / DIAGRAM).is_file() or _asked(path) == "schelling"


def is_cross_play(path: Path) -> bool:
    """Returns whether a folder is that of a cross-play, or of one that was begun."""
    return (path / CROSS_PLAY).is_file() or _asked(path) == "crossplay"


def _asked(path: Path) -> Any:
    try:
        return read_json(path / ASKED).get("experiment")
    except (OSError, ValueError, AttributeError):
        return None


def read_diagram(path: Path) -> Evidence:
    """Returns the contrasts and the verdict of a diagram. Raises ReportError for a file of another format."""
    return _read(path, DIAGRAM, _diagram)


def read_cross_play(path: Path) -> Evidence:
    """Returns what each policy earned in each mixture. Raises ReportError for a file of another format."""
    return _read(path, CROSS_PLAY, _cross_play)


def _read(path: Path, name: str, evidence_of: Any) -> Evidence:
    file = path / name
    if not file.is_file():
        return Evidence(notes=(f"`{path}` is an experiment that is not finished: it is left out, and the same command goes on with it",))
    try:
        stored = read_json(file)
        if stored["format"] != FORMAT:
            raise ReportError(f"{file} has the format {stored['format']}, and {FORMAT} is read here; play it again")
        found: Evidence = evidence_of(stored)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ReportError(f"{file} cannot be read ({type(error).__name__}: {error})") from None
    return found


def _diagram(stored: Mapping[str, Any]) -> Evidence:
    game, verdict, contrasts = stored["game"], stored["verdict"], stored["contrasts"]
    bounds = {name: _bounds(figure) for name, figure in contrasts.items()}
    mean = {name: rounded(figure["mean"]) for name, figure in contrasts.items()}
    row = DiagramRow(
        game["name"],
        game["hash"],
        " ".join(other_numbers(game)),
        game["num_agents"],
        stored["cooperators"],
        stored["defectors"],
        stored["unit"],
        stored["units"],
        stored["episodes"],
        verdict["outcome"],
        verdict["fear"],
        verdict["greed"],
        verdict["reason"],
        verdict.get("caution") or "",
        *(mean["A"], *bounds["A"]),
        *(mean["B"], *bounds["B"]),
        *(mean["fear"], *bounds["fear"]),
        *(mean["greed"], *bounds["greed"]),
    )
    return Evidence(diagrams=(row,), notes=tuple(stored.get("notes", ())))


def _cross_play(stored: Mapping[str, Any]) -> Evidence:
    """Returns the meetings; of a mixture of random policies alone also what a random policy earns."""
    game, number = stored["game"], stored["game"]["num_agents"]
    of = (game["name"], game["hash"], " ".join(other_numbers(game)), number)
    meetings, random = [], []
    for mixture in stored["mixtures"]:
        unit = mixture.get("unit", stored["unit"])
        units = len(stored["keys"]) if unit == "training seed" else mixture["episodes"]
        for policy, figure in mixture["policies"].items():
            low, high = _bounds(figure)
            mean, episodes = rounded(figure["mean"]), mixture["episodes"]
            meetings.append(Meeting(*of, mixture["mixture"], policy, mean, low, high, unit, units, episodes))
            if set(mixture["slots"]) == {"random"} and not meetings[-1].params:
                least, most = (None if bound is None else rounded(number * bound) for bound in (low, high))
                random.append(RandomRow(game["name"], game["hash"], rounded(number * mean), least, most, episodes))
    return Evidence(meetings=tuple(meetings), random=tuple(random), notes=tuple(stored.get("notes", ())))


def _bounds(figure: Mapping[str, Any]) -> tuple[float | None, float | None]:
    """Returns the bounds of an interval; None where one sample has none."""
    low, high = figure["low"], figure["high"]
    return None if low is None else rounded(low), None if high is None else rounded(high)
