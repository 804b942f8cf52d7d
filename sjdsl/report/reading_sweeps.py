"""Reads the folder of a sweep: its cells are ordinary runs."""

import csv
from pathlib import Path
from typing import Any

from sjdsl.files import read_json
from sjdsl.report.evidence import Evidence, merged
from sjdsl.report.reading_runs import is_run, read_run
from sjdsl.report.refusals import ReportError

SWEEP, CELLS, STATUS = "sweep.json", "cells", "status.csv"


def is_sweep(path: Path) -> bool:
    """Returns whether a folder is that of a sweep."""
    return (path / SWEEP).is_file()


def read_sweep(path: Path) -> Evidence:
    """Returns what the cells of a sweep have found; cells that are still to be trained are noted by their number.

    Raises:
      ReportError: its `sweep.json` cannot be read.
    """
    stages = _stages(path)
    there = [name for name in stages if is_run(path / CELLS / name)]
    parts = [read_run(path / CELLS / name, stages[name]) for name in there]
    return merged([*parts, Evidence(notes=_notes(path, len(stages) - len(there)))])


def is_cell(path: Path) -> bool:
    """Returns whether a folder is that of a run, in the place of a cell of a sweep."""
    return is_run(path) and path.resolve().parent.name == CELLS and is_sweep(path.resolve().parents[1])


def read_cell(path: Path) -> Evidence:
    """Returns what one cell of a sweep has found, which is named without its sweep, as in `SWEEP/cells/*`.

    Raises:
      ReportError: the run, or the `sweep.json` of its sweep, cannot be read.
    """
    cell = path.resolve()
    return read_run(path, _stages(cell.parents[1]).get(cell.name))


def _stages(path: Path) -> dict[str, int | None]:
    """Returns the cells of a sweep by name, with the stage of each."""
    try:
        stored = read_json(path / SWEEP)
        if any(Path(name).name != name for name in stored["cells"]):
            raise ValueError("a cell is named by a path")
        return {name: _stage(stored.get("protocol"), cell) for name, cell in stored["cells"].items()}
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ReportError(f"{path / SWEEP} cannot be read ({type(error).__name__}: {error})") from None


def _stage(protocol: str | None, cell: dict[str, Any]) -> int | None:
    """Returns which stage of a sweep of svo a cell is of; None in other sweeps. The seeds of the two stages are never taken together."""
    return int(cell["stage"]) if protocol == "svo" else None


def _notes(path: Path, absent: int) -> tuple[str, ...]:
    notes = []
    if absent:
        notes.append(f"{absent} cell{'s' if absent > 1 else ''} of the sweep `{path}` {'are' if absent > 1 else 'is'} still to be trained")
    if (path / STATUS).is_file():
        with open(path / STATUS, encoding="utf-8", newline="") as file:
            failed = [row["cell"] for row in csv.DictReader(file) if row.get("state") == "failed"]
        notes += [f"the cell `{cell}` of the sweep `{path}` has failed" for cell in failed]
    return tuple(notes)
