"""Lowers cells as values: a field keeps 256 times the row of its cell and the column; -1 is nowhere."""

from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import Value, binary, literal, select
from sjdsl.compiler.lower.scope import CellVar, IterationScope
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program import expressions as array

ROW = 8  # bits of a column: a map has at most 256
NOWHERE = -1


def nowhere(w: Writer) -> Value:
    """Returns the number that stands for no cell."""
    return Value(w.module.number("no_cell", NOWHERE, "in place of a cell: 256 * row + column"), "i32")


def kept(e: ir.Expr, scope: IterationScope, w: Writer) -> Value:
    """Returns a cell as a field keeps it."""
    if not isinstance(e, ir.Member):
        return w.value(e, scope.always())
    variable = scope.variables[e.name]
    assert isinstance(variable, CellVar)
    at = state_reads.cell(variable, w)
    cols, pad = w.module.number("frame_cols", w.module.layout.cols), array.Literal(w.module.layout.pad, "PAD")
    row, col = (array.Binary("-", array.Binary(op, at.node, cols), pad) for op in ("//", "%"))
    return w.keep("place", replace(at, node=array.Binary("+", array.Binary("<<", row, array.Literal(ROW)), col)))


def frame(value: Value, w: Writer) -> Value:
    """Returns the cell of the frame that a kept one is; 0 for nowhere."""
    cols, pad = w.module.number("frame_cols", w.module.layout.cols), array.Literal(w.module.layout.pad, "PAD")
    row = array.Binary("+", array.Binary(">>", value.node, array.Literal(ROW)), pad)
    col = array.Binary("+", array.Binary("&", value.node, array.Literal((1 << ROW) - 1)), pad)
    at = replace(value, node=array.Binary("+", array.Binary("*", row, cols), col))
    return w.keep("at", select(binary(">=", value, literal(0, "i32"), "bool"), at, state_reads.nowhere(w)))


def variable(e: ir.Expr, kinds: tuple[str, ...], scope: IterationScope, w: Writer) -> CellVar:
    """Returns the variable that a cell value is among the cells of some kinds; none of them for nowhere."""
    at = frame(w.value(e, scope.always()), w)
    return CellVar(w.keep("_".join(kinds) + "_held", state_reads.site_at(at, kinds, w)), kinds)
