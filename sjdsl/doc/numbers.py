"""The table of params and sizes: default, unit, limits, when each can change, and its source."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.types import UNIT_LIMITS
from sjdsl.doc.wording import code, number, plain, table, table_value
from sjdsl.doc.written import Written

HEAD = ("name", "default", "unit", "may be", "can be changed", "source")


def parameters(w: Written) -> list[str]:
    """Returns the section on the numbers of a game."""
    rows = [_row(size, w, "before compiling") for size in w.game.sizes]
    rows += [_row(param, w, "at any time") for param in w.game.params]
    return [*table(HEAD, rows), ""] if rows else ["The game has no named numbers.", ""]


def _row(declared: ir.Size | ir.Param, w: Written, when: str) -> tuple[str, ...]:
    """Returns the line of a size or param in the table. when: it can be changed."""
    written = w.numbers[declared.name]
    default = table_value(declared.value, declared.type.indexed_by)
    for keys, text in written.formulas:
        default += f"; {' '.join([*map(code, keys), 'computed as'])} {code(text)}"
    return (
        code(declared.name),
        default,
        unit_of(declared),
        limits_of(declared, w),
        when,
        plain(written.source),
    )


def unit_of(declared: ir.Size | ir.Param) -> str:
    return "word" if declared.type.kind == "word" else declared.type.unit


def limits_of(declared: ir.Size | ir.Param, w: Written) -> str:
    """Returns the limits of a number, as written: the compiler narrows those of a size."""
    if declared.type.kind == "word":
        return "one of " + ", ".join(map(code, declared.type.words))
    written = w.numbers[declared.name]
    if written.low and written.high:
        return f"{written.low} to {written.high}"
    low, high = UNIT_LIMITS[declared.type.unit]
    if high == float("inf"):
        return "any" if low == -float("inf") else f"{number(low)} or more"
    return f"{number(low)} to {number(high)}"
