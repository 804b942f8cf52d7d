"""The metrics of a run: one line an update, written at once, and truncated to the checkpoint when a run resumes.

A run of many small updates has more rows than fit into memory, so nothing here holds them all.
"""

import json
import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TextIO

from pydantic import Field, TypeAdapter

from sjdsl.files import naming, open_in_place, read_lines

from .run_errors import RunError
from .run_files import plain
from .stages import stage_folders

METRICS_JSONL = "metrics.jsonl"
EVALUATIONS = "evaluations.jsonl"

Row = dict[str, Any]  # one line of the metrics: column -> number; NaN if missing
Whole = Annotated[int, Field(strict=True, ge=0, lt=2**63)]
Figure = Whole | Annotated[float, Field(strict=True)] | None


ROWS: dict[str, TypeAdapter[Row]] = {
    METRICS_JSONL: TypeAdapter(dict[str, Figure]),
    EVALUATIONS: TypeAdapter(dict[str, Figure | dict[str, Figure]]),
}
COLUMNS = {
    METRICS_JSONL: {"env_steps"},
    EVALUATIONS: {"update", "collective return"},
}  # of each row
OF_A_RUN = {
    "update",
    "seconds",
    "episodes",
}  # further columns of the metrics, without which a run isn't resumed


@dataclass(frozen=True)
class Metrics:
    """The open `metrics.jsonl` of one seed. All rows have the same columns."""

    lines: TextIO

    def append(self, row: Row) -> None:
        """Writes one row and flushes it."""
        self.lines.write(json.dumps(plain(row)) + "\n")
        with naming(self.lines.name):
            self.lines.flush()

    def to_disk(self) -> None:
        """Makes the system write what was appended, so that nothing is lost even if the machine stops."""
        os.fsync(self.lines.fileno())


@contextmanager
def open_metrics(folder: Path) -> Iterator[Metrics]:
    """Opens the metrics of one seed for appending."""
    with open_in_place(folder / METRICS_JSONL, "a") as lines:
        yield Metrics(lines)


def cut_metrics(folder: Path, done: int, evaluate_every: int = 0) -> Iterator[Row]:
    """Drops what was written after update `done`, including half a line; yields the remaining rows of the metrics, one at a time.

    Nothing is dropped before the last row has been taken.

    Args:
      folder: of a seed.
      evaluate_every: updates from one evaluation to the next; 0: none.
    Raises:
      RunError: rows up to that update, or evaluations, are lost.
    """
    lines, evaluations = folder / METRICS_JSONL, folder / EVALUATIONS
    size, last = 0, Row()
    for line, row in _whole_lines(lines) if done else ():
        if not row.keys() >= OF_A_RUN or row["update"] != last.get("update", 0) + 1:
            break
        size += len(line)
        last = known_row(row)
        yield last
        if last["update"] == done:  # what follows may be anything
            break
    known, diverged = (
        last.get("update", 0),
        not math.isfinite(last.get("loss", 0.0)),
    )  # a seed that has diverged has no more rows
    if known != done and not diverged:
        raise RunError(
            f"{lines} is damaged: it holds only the first {known} of the {done} updates. Restore the file; or resume from an earlier update "
            f"by removing the later ones from {folder / 'checkpoints'} (with several seeds, from the folder above)"
        )
    wanted = (
        range(evaluate_every, known - diverged + 1, evaluate_every) if evaluate_every else range(0)
    )
    found = [
        line
        for number, (line, row) in zip(wanted, _whole_lines(evaluations), strict=False)
        if row.get("update") == number
    ]
    if len(found) < len(wanted):
        raise RunError(
            f"{evaluations} is damaged: it holds only {len(found)} of {len(wanted)} evaluations. Restore the file, or start a new run"
        )
    _cut(lines, size)
    _cut(evaluations, sum(map(len, found)))


def read_rows(path: Path) -> Iterator[Row]:
    """Yields the rows of a file of JSON lines, one at a time, without half a line at the end, which a killed process leaves.

    Raises:
      RunError: a line can't be read.
    """
    return (known_row(row) for _, row in _whole_lines(path))


def run_rows(folder: Path) -> Iterator[Row]:
    """Yields the rows of a seed of a run, those of all its stages, one at a time. folder: that of the last stage.

    Raises:
      RunError: a line can't be read.
    """
    for stage in stage_folders(folder):
        yield from read_rows(stage / METRICS_JSONL)


def known_row(row: Row) -> Row:
    """Returns a row as it was before it became JSON: NaN for missing values."""
    return {name: math.nan if value is None else value for name, value in row.items()}


def thinned_rows(folder: Path, most: int) -> list[Row]:
    """Returns the rows in which episodes finished; if there are more than `most`, neighbours of one stage are averaged."""
    number = sum(row["episodes"] > 0 for row in run_rows(folder))
    together = max(1, math.ceil(number / most))
    thinned: list[Row] = []
    size = 0
    for row in run_rows(folder):
        if not row["episodes"] > 0:
            continue
        if size in (0, together) or row.get("stage") != thinned[-1].get("stage"):
            thinned.append(row)
            size = 1
        else:
            size += 1
            thinned[-1] = {
                name: before + (row[name] - before) / size for name, before in thinned[-1].items()
            }
    return thinned


def append_line(path: Path, row: Row) -> None:
    """Appends a row to a file of JSON lines."""
    with naming(path), open_in_place(path, "a") as file:
        file.write(json.dumps(plain(row)) + "\n")
        file.flush()
        os.fsync(file.fileno())


def _whole_lines(path: Path) -> Iterator[tuple[bytes, Row]]:
    """Yields the lines of a file of JSON lines and their rows, up to one that was cut off when the process was killed."""
    if not path.exists():
        return
    number = 0
    try:
        for line in read_lines(path):
            number += 1
            row = ROWS[path.name].validate_json(line)
            if not row.keys() >= COLUMNS[path.name]:
                raise ValueError("a column is missing")
            yield line, row
    except ValueError:
        raise RunError(
            f"{path} is damaged: its line {number} can't be read. Restore the file"
        ) from None
    except OSError as error:
        raise RunError(f"{path} can't be read: {error.strerror}. Restore the file") from None


def _cut(path: Path, size: int) -> None:
    if path.exists() and path.stat().st_size > size:
        with naming(path), open_in_place(path, "r+") as file:
            file.truncate(size)
