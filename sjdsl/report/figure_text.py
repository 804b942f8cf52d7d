"""Figures as text: means with bounds, as people read them."""

from sjdsl.report.cells import Cell

SHOWN = 4  # digits


def number(value: float) -> str:
    """Returns a figure in four digits at most: `0.91`, `163.2`, `1,780`."""
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value + 0.0:.{SHOWN}g}"


def rough(value: float) -> str:
    """Returns a figure in two digits: `110`, `1.5`."""
    return number(float(f"{value:.2g}"))


def bounded(mean: float, low: float | None, high: float | None) -> str:
    """Returns `163.2 [160.1, 166.3]`; one sample has no bounds."""
    if low is None or high is None or abs(low) == float("inf"):
        return number(mean)
    return f"{number(mean)} [{number(low)}, {number(high)}]"


def cell_text(cell: Cell | None) -> str:
    """Returns a cell: nothing where there is none, `failed` where a seed has."""
    if cell is None:
        return ""
    found = cell.estimate
    if found is None:
        return f"failed: {cell.failed} of {cell.seeds} seeds" if cell.seeds > 1 else "failed"
    return bounded(found.mean, found.low, found.high)


def finite(value: float) -> float | None:
    """Returns a bound as a table has it: None where it is infinite."""
    return None if abs(value) == float("inf") else value
