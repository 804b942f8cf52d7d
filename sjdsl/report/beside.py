"""Tables in which our cells stand beside the published ones: three lines a game."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from sjdsl.report.cells import Cell
from sjdsl.report.figure_text import cell_text, finite, number
from sjdsl.report.page import Table
from sjdsl.report.published import Printed

ORIGIN = "seeds, steps, hardware"


@dataclass(frozen=True)
class Line:
    """A game of such a table: its cells and the published ones by column, and what stands behind them."""

    label: str
    cells: Sequence[Cell | None]
    printed: Sequence[Printed | None]
    ours_more: tuple[str, ...] = ()
    printed_more: tuple[str, ...] = ()


def beside_table(name: str, title: str, columns: Sequence[str], lines: Sequence[Line], more: Sequence[str] = ()) -> Table:
    """Returns a table of games: our cells, the published ones, and the difference with whether theirs lies in our interval.

    No test is made: the number of seeds behind a published cell is not known.
    """
    rows = [row for line in lines for row in _rows(line, len(more))]
    records = [record for line in lines for record in _records(line, columns, more)]
    return Table(name, title, ("game", "", *columns, *more, ORIGIN), tuple(rows), tuple(records), 2)


def _rows(line: Line, more: int) -> Iterator[tuple[str, ...]]:
    alike, apart = shared_origins(line.cells)
    shown = [
        cell_text(cell) + ("" if cell is None or not apart else f" ({', '.join(cell.origins[n] for n in apart)})") for cell in line.cells
    ]
    yield (line.label, "ours", *shown, *(line.ours_more or ("",) * more), alike)
    if any(printed is not None for printed in line.printed):
        yield ("", "published", *map(_printed, line.printed), *(line.printed_more or ("",) * more), "")
    differences = [_difference(cell, printed) for cell, printed in zip(line.cells, line.printed, strict=True)]
    if any(found is not None for found in differences):
        yield ("", "ours - published", *map(_difference_text, differences), *("",) * more, "")


def shared_origins(cells: Sequence[Cell | None]) -> tuple[str, list[int]]:
    """Returns what all cells of a line have alike of seeds, steps and hardware, and which of the three they have not: each cell says it."""
    kinds = list(zip(*(cell.origins for cell in cells if cell is not None), strict=True))
    apart = [number for number, found in enumerate(kinds) if len(set(found)) > 1]
    return ", ".join(found[0] for number, found in enumerate(kinds) if number not in apart), apart


def _printed(printed: Printed | None) -> str:
    if printed is None:
        return ""
    return number(printed.mean) if printed.deviation is None else f"{number(printed.mean)} ± {number(printed.deviation)}"


def _difference(cell: Cell | None, printed: Printed | None) -> tuple[float, bool | None] | None:
    """Returns by how much ours is more, and whether theirs lies in our interval; None for the latter where one seed has no interval."""
    if cell is None or cell.estimate is None or printed is None:
        return None
    found = cell.estimate
    inside = None if finite(found.low) is None else found.low <= printed.mean <= found.high
    return found.mean - printed.mean, inside


def _difference_text(found: tuple[float, bool | None] | None) -> str:
    if found is None:
        return ""
    difference, inside = found
    where = {None: "", True: ", inside", False: ", outside"}[inside]
    return f"{'+' if difference > 0 else ''}{number(difference)}{where}"


def _records(line: Line, columns: Sequence[str], more: Sequence[str]) -> Iterator[dict[str, Any]]:
    said = dict(zip(more, line.ours_more or ("",) * len(more), strict=True))
    said |= {f"published {heading}": value for heading, value in zip(more, line.printed_more or ("",) * len(more), strict=True)}
    for column, cell, printed in zip(columns, line.cells, line.printed, strict=True):
        if cell is not None or printed is not None:
            difference, inside = _difference(cell, printed) or (None, None)
            yield {
                "game": line.label,
                "column": column,
                **cell_record(cell),
                "published": printed and printed.mean,
                "published_deviation": printed and printed.deviation,
                "difference": difference,
                "published_inside": inside,
                **said,
            }


def cell_record(cell: Cell | None) -> dict[str, Any]:
    """Returns all that a row of a CSV has of a cell."""
    found = None if cell is None else cell.estimate
    return {
        "mean": found and found.mean,
        "low": found and finite(found.low),
        "high": found and finite(found.high),
        "seeds": cell and cell.seeds,
        "failed": cell and cell.failed,
        "steps": cell and cell.steps,
        "hardware": cell and cell.hardware,
        "run": cell and cell.run.run,
    }
