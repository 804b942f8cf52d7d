"""The metrics files of a run: one line an update, written at once, and truncated to the checkpoint when a run resumes.

A run of many small updates has more rows than fit into memory, so nothing here holds them all.
"""

import csv
import json
import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

from sjdsl.files import naming, open_in_place

from .run_errors import RunError
from .run_files import plain

METRICS_JSONL = "metrics.jsonl"
METRICS_CSV = "metrics.csv"
EVALUATIONS = "evaluations.jsonl"

Row = dict[str, Any]  # one line of the metrics: column -> number; NaN if missing


@dataclass(frozen=True)
class Metrics:
    """The open metrics of one seed: `metrics.jsonl` and `metrics.csv`. All rows have the same columns."""

    lines: TextIO
    table: TextIO

    def append(self, row: Row) -> None:
        """Writes one row to both files and flushes them."""
        known = plain(row)
        writer = csv.writer(self.table)
        if self.table.tell() == 0:
            writer.writerow(known)
        writer.writerow(known.values())
        self.lines.write(json.dumps(known) + "\n")
        for file in (self.table, self.lines):
            with naming(file.name):
                file.flush()

    def to_disk(self) -> None:
        """Makes the system write what was appended, so that nothing is lost even if the machine stops."""
        for file in (self.lines, self.table):
            os.fsync(file.fileno())


@contextmanager
def open_metrics(folder: Path) -> Iterator[Metrics]:
    """Opens the metrics of one seed for appending."""
    with (
        open_in_place(folder / METRICS_JSONL, "a") as lines,
        open_in_place(folder / METRICS_CSV, "a", newline="") as table,
    ):
        yield Metrics(lines, table)


def cut_metrics(folder: Path, update: int) -> Iterator[Row]:
    """Drops what was written after an update, including half a line; yields the remaining rows of the metrics, one at a time.

    Nothing is dropped before the last row has been taken.
    """
    size = kept = 0
    for line, row in _whole_lines(folder / METRICS_JSONL):
        if row["update"] > update:
            break
        size += len(line)
        kept += 1
        yield known_row(row)
        if row["update"] == update:
            break
    _cut(folder / METRICS_JSONL, size)
    table = folder / METRICS_CSV
    _cut(table, _size_of_lines(table, kept + 1) if kept else 0)
    evaluations = folder / EVALUATIONS
    _cut(evaluations, sum(len(line) for line, row in _whole_lines(evaluations) if row["update"] <= update))


def read_rows(path: Path) -> Iterator[Row]:
    """Yields the rows of a file of JSON lines, one at a time, without half a line at the end, which a killed process leaves.

    Raises:
      RunError: a line can't be read.
    """
    return (known_row(row) for _, row in _whole_lines(path))


def known_row(row: Row) -> Row:
    """Returns a row as it was before it became JSON: NaN for missing values."""
    return {name: math.nan if value is None else value for name, value in row.items()}


def thinned_rows(folder: Path, most: int) -> list[Row]:
    """Returns the rows in which episodes finished; if there are more than `most`, neighbours are averaged."""
    number = sum(row["episodes"] > 0 for row in read_rows(folder / METRICS_JSONL))
    together = max(1, math.ceil(number / most))
    thinned: list[Row] = []
    size = 0
    for row in read_rows(folder / METRICS_JSONL):
        if not row["episodes"] > 0:
            continue
        if size in (0, together):
            thinned.append(row)
            size = 1
        else:
            size += 1
            thinned[-1] = {name: before + (row[name] - before) / size for name, before in thinned[-1].items()}
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
    with open(path, "rb") as file:
        for number, line in enumerate(file, start=1):
            if not line.endswith(b"\n"):
                return
            try:
                row = json.loads(line)
            except ValueError:
                row = None
            if not isinstance(row, dict):
                raise RunError(f"{path} is damaged: its line {number} can't be read. Restore the file")
            yield line, row


def _size_of_lines(path: Path, number: int) -> int:
    """Returns the bytes of the first lines of a file."""
    if not path.exists():
        return 0
    with open(path, "rb") as file:
        return sum(len(line) for line, _ in zip(file, range(number), strict=False))


def _cut(path: Path, size: int) -> None:
    if path.exists() and path.stat().st_size > size:
        with naming(path), open_in_place(path, "r+") as file:
            file.truncate(size)
