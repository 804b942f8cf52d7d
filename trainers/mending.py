"""Looks whether the metrics of a stopped run are whole, and makes a damaged file again from the other, which has the same rows.

What a process that is killed leaves is half a line at the end. Anything else has been done to the file since.
"""

import csv
import json
import math
import warnings
from collections.abc import Iterator
from io import TextIOWrapper
from pathlib import Path
from typing import Any

from sjdsl.files import written_whole

from .metrics_files import EVALUATIONS, METRICS_CSV, METRICS_JSONL, Metrics, Row, known_row
from .run_errors import RunError


def mend_metrics(folder: Path, done: int, evaluate_every: int) -> None:
    """Has both files of metrics hold the rows of all updates that were done; says so where one was damaged.

    Args:
      folder: of a seed.
      done: the update that the run goes on from.
      evaluate_every: updates from one evaluation to the next; 0: there is none.
    Raises:
      RunError: rows are in neither file, or evaluations are lost.
    """
    lines, table = folder / METRICS_JSONL, folder / METRICS_CSV
    in_lines, in_table = (_last_of(rows, done) for rows in (_in_lines(lines), _in_table(table)))
    whole = [path for path, last in ((lines, in_lines), (table, in_table)) if _is_last(last, done)]
    if not whole:
        known = max(int(last.get("update", 0)) for last in (in_lines, in_table))
        raise RunError(
            f"{lines} and {table.name} are damaged: they hold only the first {known} of the {done} updates. Put one of them back as "
            f"it was; or go on from an earlier update: remove the later ones from {folder / 'checkpoints'}, or of several seeds from the "
            "folder above"
        )
    if lines not in whole or table not in whole:
        damaged = table if lines in whole else lines
        warnings.warn(f"{damaged} was damaged: it is made again from {whole[0].name}", stacklevel=2)
        _write_again(folder, _in_lines(lines) if lines in whole else _in_table(table), done)
    last = in_lines if lines in whole else in_table
    _check_evaluations(folder / EVALUATIONS, _learnt(last), evaluate_every)


def _last_of(rows: Iterator[Row], done: int) -> Row:
    """Returns the last of the rows of updates 1, 2 and so on, up to `done`; an empty one where there is none."""
    last: Row = {}
    for row in rows:
        if last.get("update", 0) == done or row.get("update") != last.get("update", 0) + 1:
            break
        last = row
    return last


def _is_last(row: Row, done: int) -> bool:
    """Whether nothing was written after a row: it is of the last update, or of the one in which its seed diverged."""
    return row.get("update", 0) == done or (bool(row) and not math.isfinite(row.get("loss", 0.0)))


def _learnt(row: Row) -> int:
    """Returns the updates after which a seed had a policy to evaluate; `row` is its last."""
    number = int(row.get("update", 0))
    return number if not row or math.isfinite(row.get("loss", 0.0)) else number - 1


def _check_evaluations(path: Path, learnt: int, every: int) -> None:
    wanted = [*range(every, learnt + 1, every)] if every else []
    found = [row.get("update") for row in _in_lines(path)][: len(wanted)]
    if found != wanted:
        missing = next(number for index, number in enumerate(wanted) if found[index : index + 1] != [number])
        raise RunError(
            f"{path} is damaged: the evaluation after update {missing} cannot be read. Put it back as it was, or start a new run"
        )


def _in_lines(path: Path) -> Iterator[Row]:
    """Yields the rows of a file of JSON lines, up to the first that is none."""
    if not path.exists():
        return
    with open(path, "rb") as file:
        for line in file:
            row = _json(line.decode("utf-8", errors="replace")) if line.endswith(b"\n") else None
            if not isinstance(row, dict):
                return
            yield known_row(row)


def _in_table(path: Path) -> Iterator[Row]:
    """Yields the rows of a table, up to the first that is none: the numbers as `metrics.jsonl` has them."""
    if not path.exists():
        return
    with open(path, "rb") as file:
        whole = (line.decode("utf-8", errors="replace") for line in file if line.endswith(b"\r\n"))
        table = csv.reader(whole)
        names = next(table, [])
        for cells in table:
            values = [None if cell == "" else _json(cell) for cell in cells]
            if len(cells) != len(names) or any(value is None and cell for value, cell in zip(values, cells, strict=True)):
                return
            yield known_row(dict(zip(names, values, strict=True)))


def _json(text: str) -> Any:
    """Returns what a text says in JSON; None for one that is none."""
    try:
        return json.loads(text)
    except ValueError:
        return None


def _write_again(folder: Path, rows: Iterator[Row], done: int) -> None:
    """Writes both files with the rows up to an update, one at a time, and puts them in the place of the old ones."""
    with written_whole(folder / METRICS_JSONL) as lines, written_whole(folder / METRICS_CSV) as table:
        texts = [TextIOWrapper(file, encoding="utf-8", newline="") for file in (lines, table)]
        metrics = Metrics(*texts)
        for row in rows:
            if row["update"] > done:
                break
            metrics.append(row)
        for text in texts:
            text.detach()
