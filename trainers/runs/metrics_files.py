"""The metrics of a run: one line an update, truncated to the checkpoint when a run resumes.

A run of many small updates has more rows than fit into memory, so nothing here holds them all.
"""

import json
import math
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, TypeAdapter

from sjdsl.files import naming, open_in_place, read_lines

from ..json_files import plain
from .run_errors import RunError
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
# of each row
COLUMNS = {METRICS_JSONL: {"env_steps"}, EVALUATIONS: {"update", "collective return"}}
# further columns of the metrics, without which a run isn't resumed
OF_A_RUN = {"update", "seconds", "episodes"}


def cut_metrics(folder: Path, done: int, evaluate_every: int = 0) -> Iterator[Row]:
    """Drops what was written after update `done`, including half a line.

    It yields the remaining rows of the metrics, one at a time. Nothing is dropped before the last
    row has been taken.

    Args:
      folder: of a seed.
      evaluate_every: updates from one evaluation to the next; 0: none.
    Raises:
      RunError: rows up to that update, or evaluations, are lost.
    """
    metrics = folder / METRICS_JSONL
    size = 0
    last: Row = {"update": 0}
    for line, row in _lines_of(metrics, range(1, done + 1)):
        if not row.keys() >= OF_A_RUN:
            break
        size += len(line)
        last = known_row(row)
        yield last
    known = last["update"]
    # A seed that has diverged has no more rows, and no evaluation after its last.
    is_diverged = not math.isfinite(last.get("loss", 0.0))
    if known != done and not is_diverged:
        raise RunError(
            f"{metrics} is damaged: it holds only the first {known} of the {done} updates. Restore "
            "the file; or resume from an earlier update by removing the later ones from "
            f"{folder / 'checkpoints'} (with several seeds, from the folder above)"
        )
    evaluations = folder / EVALUATIONS
    wanted: Sequence[int] = ()  # updates that were evaluated
    if evaluate_every:
        last_evaluated = known - 1 if is_diverged else known
        wanted = range(evaluate_every, last_evaluated + 1, evaluate_every)
    kept = [line for line, _ in _lines_of(evaluations, wanted)]
    if len(kept) < len(wanted):
        raise RunError(
            f"{evaluations} is damaged: it holds only {len(kept)} of {len(wanted)} evaluations. "
            "Restore the file, or start a new run"
        )
    _cut(metrics, size)
    _cut(evaluations, sum(map(len, kept)))


def _lines_of(path: Path, updates: Iterable[int]) -> Iterator[tuple[bytes, Row]]:
    """Yields the lines of these updates and their rows, up to the first that is missing.

    What follows the last may be anything.
    """
    for update, (line, row) in zip(updates, _whole_lines(path), strict=False):
        if row.get("update") != update:
            return
        yield line, row


def read_rows(path: Path) -> Iterator[Row]:
    """Yields the rows of a file of JSON lines, one at a time.

    A killed process may leave half a line at the end, which is left out.

    Raises:
      RunError: a line can't be read.
    """
    return (known_row(row) for _, row in _whole_lines(path))


def run_rows(folder: Path) -> Iterator[Row]:
    """Yields the rows of a seed of a run, those of all its stages, one at a time.

    Args:
      folder: that of the last stage.
    Raises:
      RunError: a line can't be read.
    """
    for stage in stage_folders(folder):
        yield from read_rows(stage / METRICS_JSONL)


def known_row(row: Row) -> Row:
    """Returns a row as it was before it became JSON: NaN for missing values."""
    return {name: math.nan if value is None else value for name, value in row.items()}


def thinned_rows(folder: Path, most: int) -> list[Row]:
    """Returns the rows in which episodes finished.

    If there are more than `most`, neighbours of one stage are averaged.
    """
    number = sum(row["episodes"] > 0 for row in run_rows(folder))
    together = math.ceil(number / most)
    thinned: list[Row] = []
    size = together  # rows in the last of them
    for row in run_rows(folder):
        if not row["episodes"] > 0:
            continue
        if size == together or row.get("stage") != thinned[-1].get("stage"):
            thinned.append(row)
            size = 1
            continue
        size += 1
        mean = thinned[-1]
        for name in mean:
            mean[name] += (row[name] - mean[name]) / size
    return thinned


def append_line(path: Path, row: Row) -> None:
    """Appends a row to a file of JSON lines."""
    with naming(path), open_in_place(path, "a") as file:
        file.write(json.dumps(plain(row)) + "\n")


def to_disk(path: Path) -> None:
    """Makes the system write what was appended to a file, in case the machine stops."""
    with naming(path), open_in_place(path, "a") as file:
        os.fsync(file.fileno())


def _whole_lines(path: Path) -> Iterator[tuple[bytes, Row]]:
    """Yields the lines of a file of JSON lines and their rows, up to one that was cut off."""
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
    """Drops what a file has beyond so many bytes."""
    if path.exists() and path.stat().st_size > size:
        with naming(path), open_in_place(path, "r+") as file:
            file.truncate(size)
