"""Checks whether the metrics of a stopped run are whole, and restores a damaged file from the other, which has the same rows.

A process that is killed leaves half a line at the end. Anything else happened to the file later.
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
    """Makes sure that both files of metrics hold the rows of all updates so far; warns if one was damaged.

    Args:
      folder: of a seed.
      done: the update after which the run resumes.
      evaluate_every: updates from one evaluation to the next; 0: none.
    Raises:
      RunError: some rows are in neither file, or evaluations are lost.
    """
    lines, table = folder / METRICS_JSONL, folder / METRICS_CSV
    in_lines, in_table = (_last_of(rows, done) for rows in (_in_lines(lines), _in_table(table)))

    def is_last(row: Row) -> bool:  # of the last update, or of the one in which the seed diverged
        return row.get("update", 0) == done or (bool(row) and not math.isfinite(row.get("loss", 0.0)))

    whole = [path for path, last in ((lines, in_lines), (table, in_table)) if is_last(last)]
    if not whole:
        known = max(int(last.get("update", 0)) for last in (in_lines, in_table))
        raise RunError(
            f"{lines} and {table.name} are damaged: they hold only the first {known} of the {done} updates. Restore one of them; or resume "
            f"from an earlier update by removing the later ones from {folder / 'checkpoints'} (with several seeds, from the folder above)"
        )
    if lines not in whole or table not in whole:
        damaged = table if lines in whole else lines
        warnings.warn(f"{damaged} was damaged: it is restored from {whole[0].name}", stacklevel=2)
        _write_again(folder, _in_lines(lines) if lines in whole else _in_table(table), done)
    last = in_lines if lines in whole else in_table
    learnt = int(last.get("update", 0)) - (not math.isfinite(last.get("loss", 0.0)))  # updates after which there was a policy to evaluate
    wanted = [*range(evaluate_every, learnt + 1, evaluate_every)] if evaluate_every else []
    found = [row.get("update") for row in _in_lines(folder / EVALUATIONS)][: len(wanted)]
    if found != wanted:
        missing = next(number for index, number in enumerate(wanted) if found[index : index + 1] != [number])
        raise RunError(
            f"{folder / EVALUATIONS} is damaged: the evaluation after update {missing} can't be read. Restore the file, or start a new run"
        )


def _last_of(rows: Iterator[Row], done: int) -> Row:
    """Returns the last of the rows of updates 1, 2 and so on, up to `done`; an empty one if there is none."""
    last: Row = {}
    for row in rows:
        if last.get("update", 0) == done or row.get("update") != last.get("update", 0) + 1:
            break
        last = row
    return last


def _in_lines(path: Path) -> Iterator[Row]:
    """Yields the rows of a file of JSON lines, up to the first that is damaged."""
    if not path.exists():
        return
    with open(path, "rb") as file:
        for line in file:
            row = _json(line.decode("utf-8", errors="replace")) if line.endswith(b"\n") else None
            if not isinstance(row, dict):
                return
            yield known_row(row)


def _in_table(path: Path) -> Iterator[Row]:
    """Yields the rows of a table, up to the first that is damaged, with the numbers of `metrics.jsonl`."""
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
    """Returns the value of a JSON text; None if it isn't JSON."""
    try:
        return json.loads(text)
    except ValueError:
        return None


def _write_again(folder: Path, rows: Iterator[Row], done: int) -> None:
    """Replaces both files by new ones with the rows up to an update."""
    with written_whole(folder / METRICS_JSONL) as lines, written_whole(folder / METRICS_CSV) as table:
        texts = [TextIOWrapper(file, encoding="utf-8", newline="") for file in (lines, table)]
        metrics = Metrics(*texts)
        for row in rows:
            if row["update"] > done:
                break
            metrics.append(row)
        for text in texts:
            text.detach()
