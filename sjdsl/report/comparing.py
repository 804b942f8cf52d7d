"""Tables that compare two cells of ours, a line each: their difference, by Welch's t-test."""

from collections.abc import Sequence
from typing import Any

from sjdsl.report.beside import ORIGIN, cell_record
from sjdsl.report.cells import Cell
from sjdsl.report.figure_text import bounded, cell_text, number
from sjdsl.report.page import Table
from sjdsl.report.welch import Comparison, compare

Pair = tuple[tuple[str, ...], Cell | None, Cell | None]  # words, the game first, and the two cells


def compared_table(name: str, title: str, words: tuple[str, ...], columns: tuple[str, str], lines: Sequence[Pair]) -> Table:
    """Returns the table: both cells, how much more the second has with its 95 % interval, and p."""
    rows, records = [], []
    for said, first, second in lines:
        found = _compared(first, second)
        origins = list(dict.fromkeys(cell.origin for cell in (first, second) if cell is not None))
        difference = "" if found is None else bounded(found.difference, found.low, found.high)
        p = "" if found is None or found.p is None else _p(found.p)
        rows.append((*said, cell_text(first), cell_text(second), difference, p, "; ".join(origins)))
        records += [_record(words, said, column, cell) for column, cell in zip(columns, (first, second), strict=True) if cell is not None]
        if found is not None:
            difference_record = {"mean": found.difference, "low": found.low, "high": found.high, "p": found.p}
            records.append(_record(words, said, f"{columns[1]} - {columns[0]}", None) | difference_record)
    headings = (*words, *columns, f"{columns[1]} - {columns[0]}", "p (Welch)", ORIGIN)
    return Table(name, title, headings, tuple(rows), tuple(records), len(words))


def _compared(first: Cell | None, second: Cell | None) -> Comparison | None:
    if first is None or second is None or first.estimate is None or second.estimate is None:
        return None
    return compare(first.values, second.values)


def _p(value: float) -> str:
    return "< 0.001" if value < 0.001 else number(value)


def _record(words: tuple[str, ...], said: tuple[str, ...], column: str, cell: Cell | None) -> dict[str, Any]:
    return {**dict(zip(words, said, strict=True)), "column": column, **cell_record(cell), "p": None}
