"""Lowers expressions to array expressions."""

from dataclasses import replace
from functools import reduce
from typing import Literal as OneOf
from typing import assert_never

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.ir.names import param_attribute
from sjdsl.compiler.ir.operations import CALCULATIONS, REDUCTIONS, Calculation
from sjdsl.compiler.lower import cell_values, chosen, state_reads
from sjdsl.compiler.lower.aggregates import extreme, total
from sjdsl.compiler.lower.axes import (
    FALSE,
    TRUE,
    Value,
    aligned,
    as_dtype,
    binary,
    both,
    either,
    float32,
    invert,
    literal,
    select,
    summed,
    union,
)
from sjdsl.compiler.lower.condition_names import condition_name
from sjdsl.compiler.lower.entries import aligned_row, entry, to_words, words_first, words_last
from sjdsl.compiler.lower.scope import AgentVar, CellVar, IterationScope, Variable
from sjdsl.compiler.lower.writer import NOBODY, Writer
from sjdsl.compiler.program import expressions as array

LARGE = 8  # nodes of a defined condition from which on it keeps its name
ARMS = 4  # of one nested selection


def lower(e: ir.Expr, scope: IterationScope, w: Writer) -> Value:
    """Returns the array that an expression is for all instances of a scope at once."""
    match e:
        case ir.Number() | ir.Word() | ir.Truth() | ir.Nobody() | ir.Nowhere():
            return written(e, w)
        case ir.ParamRef():
            return _param(e)
        case ir.Member():
            return scope.variables[e.name].number
        case ir.Local():
            return scope.locals[e.name]
        case ir.FieldRead():
            return state_reads.field(e, None if e.owner is None else owner(e.owner, scope, w), w)
        case ir.Attribute():
            return attribute(e, scope, w)
        case ir.Distance():
            return distance(e, scope, w)
        case ir.At():
            return entry(e, scope, w)
        case ir.Step():
            return Value(w.stored("step"), "i32")
        case ir.Arithmetic():
            return arithmetic(e, scope, w)
        case ir.Compare() | ir.Same() | ir.InRange() | ir.InWords() | ir.InSet() | ir.IsEmpty():
            return test(e, scope, w)
        case ir.Chose() | ir.Unoccupied() | ir.StandsOn():
            return whereabouts(e, scope, w)
        case ir.ChoseWith():
            return chosen.chose_with(e, scope, w)
        case ir.ArgumentOf():
            return chosen.argument_of(e, scope, w)
        case ir.Not():
            return invert(lower(e.value, scope, w))
        case ir.Logic():
            return logic(e, scope, w)
        case ir.Count() | ir.Sum():
            return total(e, scope, w)
        case ir.Extreme():
            return extreme(e, scope, w)
        case ir.SumRow() | ir.Lowest() | ir.Mix():
            return of_row(e, lower(e.row, scope, w))
        case ir.ShiftRow():
            return shift(e, scope, w)
        case ir.Case():
            return case(e, scope, w)
        case ir.Named():
            return named(e, scope, w)
        case ir.Narrowed():
            return to_words(lower(e.value, scope, w), e.value.type.words, e.type.words, w)
        case ir.Before():
            return before(e, scope, w)
        case ir.EventTotal() | ir.MatrixClass():
            raise AssertionError(e)
        case _:
            assert_never(e)


def written(e: ir.Number | ir.Word | ir.Truth | ir.Nobody | ir.Nowhere, w: Writer) -> Value:
    """Returns a value that stands in the text as it is."""
    match e:
        case ir.Number():
            return literal(e.value, "i32" if e.type.kind == "int" else "f32")
        case ir.Word():
            return w.module.word(e.value, e.type.words)
        case ir.Truth():
            return literal(e.value, "bool")
        case ir.Nobody():
            return nobody(w)
        case ir.Nowhere():
            return cell_values.nowhere(w)
        case _:
            assert_never(e)


def logic(e: ir.Logic, scope: IterationScope, w: Writer) -> Value:
    """Returns the conjunction or disjunction of conditions."""
    parts = [lower(a, scope, w) for a in e.args]
    return either(parts) if e.fn == "or" else both(*parts) or TRUE


def named(e: ir.Named, scope: IterationScope, w: Writer) -> Value:
    """Returns the value of a `define`, kept under its name for all who read it; short conditions are written out instead."""
    value = lower(e.value, scope, w)
    return value if value.dtype == "bool" and len(list(walk(value.node))) < LARGE else w.keep(e.name, value)


def before(e: ir.Before, scope: IterationScope, w: Writer) -> Value:
    """Returns a value of the state before the step, which a function of checks is given beside the state."""
    here, w.state = w.state, "before"
    value = lower(e.value, scope, w)
    w.state = here
    return value


def nobody(w: Writer) -> Value:
    """Returns the number that stands for no agent."""
    return Value(w.module.number("nobody", NOBODY, "in place of an agent's number"), "i32")


def of_row(e: ir.SumRow | ir.Lowest | ir.Mix, row: Value) -> Value:
    """Returns what is made of a whole row: its sum, the word of its lowest or highest entry, or the shares of its entries."""
    match e:
        case ir.SumRow() if REDUCTIONS[e.fn].adds:
            return replace(row, node=array.Reduce("sum", summed(row.node, row.dtype), (-1,), row.dtype), levels=0)
        case ir.SumRow():
            return replace(row, node=array.Reduce(REDUCTIONS[e.fn].array, row.node, (-1,), None), levels=0)
        case ir.Lowest():
            return replace(row, node=array.call("highest" if e.last else "lowest", row.node), dtype="u8", levels=0)
        case ir.Mix():
            return Value(array.call("mix", row.node), "f32", row.axes, 1)


def shift(e: ir.ShiftRow, scope: IterationScope, w: Writer) -> Value:
    """Returns a row with its entries moved on."""
    row, filler = lower(e.row, scope, w), lower(e.filler, scope, w)
    match e.type.kind:
        case "word":
            filler = to_words(filler, e.filler.type.words, e.type.words, w)
        case "agents":
            filler = literal(0, row.dtype) if isinstance(e.filler, ir.Nobody) else filler
        case "cell":
            filler = cell_values.kept(e.filler, scope, w)
        case "int" | "real":
            row, filler = (as_dtype(part, "i32" if e.type.kind == "int" else "f32") for part in (row, filler))
        case _:
            pass
    axes = union(row.axes, filler.axes)
    fill = array.scalar(filler.node, row.dtype) if filler.literal else aligned_row(filler, axes)
    if row.levels > 1:  # of large sets
        fill = fill if filler.literal else words_first(fill)
        return replace(
            row, node=words_last(array.call("shifted", words_first(aligned_row(row, axes)), array.Literal(e.by), fill)), axes=axes
        )
    return replace(row, node=array.call("shifted", aligned_row(row, axes), array.Literal(e.by), fill), axes=axes)


def real(e: ir.Expr, scope: IterationScope, w: Writer) -> Value:
    """Returns a number as float32."""
    return as_dtype(w.value(e, scope), "f32")


def owner(e: ir.Expr, scope: IterationScope, w: Writer) -> Variable:
    """Returns the variable whose field is read: one in scope, or the agent an expression gives."""
    if isinstance(e, ir.Member):
        return scope.variables[e.name]
    if e.type.kind == "cell":
        return cell_values.variable(e, e.type.kinds, scope, w)
    return AgentVar(w.value(e, scope))


def is_cell(e: ir.Expr) -> bool:
    """Returns whether an expression is a cell: a variable, or a value."""
    return e.type.kind == "cell" or (isinstance(e, ir.Member) and e.sort.what == "cell")


def declared_by(e: ir.Expr, w: Writer) -> ir.VarField | None:
    """Returns the field that an expression is a value of, if it is nothing but that."""
    while isinstance(e, ir.At | ir.Narrowed):
        e = e.row if isinstance(e, ir.At) else e.value
    return w.module.field(e) if isinstance(e, ir.FieldRead) else None


def _param(e: ir.ParamRef) -> Value:
    dtypes: dict[str, array.DType] = {"int": "i32", "real": "f32", "word": "u8"}
    return Value(array.path(f"params.{param_attribute(e.name)}"), dtypes[e.type.kind], (), len(e.type.by))


def attribute(e: ir.Attribute, scope: IterationScope, w: Writer) -> Value:
    """Returns a read-only fact about an agent or a cell."""
    who = owner(e.owner, scope, w)
    if e.name in ("row", "col"):
        placed = _in_frame(who, e.name, w)
        return replace(placed, node=array.Binary("-", placed.node, array.Literal(w.module.layout.pad, "PAD")))
    assert isinstance(who, AgentVar)
    match e.name:
        case "index":
            return who.index
        case "heading":
            return as_dtype(state_reads.heading(who, w), "u8")
        case "moved":
            return state_reads.moved(who, w)
        case "away":
            here = state_reads.present(who, w)
            return FALSE if here is None else invert(here)
        case _:
            raise AssertionError(e)


def _in_frame(who: Variable, side: OneOf["row", "col"], w: Writer) -> Value:
    """Returns the row or column of an agent or a cell in the frame around the map."""
    at = state_reads.position(who, w) if isinstance(who, AgentVar) else state_reads.cell(who, w)
    cols = w.module.number("frame_cols", w.module.layout.cols)
    return w.keep(side, Value(array.Binary("//" if side == "row" else "%", at.node, cols), "i32", at.axes))


def distance(e: ir.Distance, scope: IterationScope, w: Writer) -> Value:
    """Returns the steps between two agents or cells, once for all who ask in this function."""
    a, b = owner(e.left, scope, w), owner(e.right, scope, w)
    for one, other in ((a, b), (b, a)):
        if isinstance(one, CellVar) and one.seen and isinstance(other, AgentVar) and other.axis == one.seen[0]:
            return state_reads.seen_steps(w, *one.seen)
    sides = [binary("-", _in_frame(a, side, w), _in_frame(b, side, w), "i32") for side in ("row", "col")]
    if w.module.layout.wraps:
        lengths = (w.module.layout.height, w.module.layout.width)
        sides = [replace(x, node=array.call("shorter_way", x.node, array.Literal(n))) for x, n in zip(sides, lengths, strict=True)]
    rows, cols = (replace(side, node=array.call("jnp.abs", side.node)) for side in sides)
    return w.keep("distance", binary("+", rows, cols, "i32"))


def arithmetic(e: ir.Arithmetic, scope: IterationScope, w: Writer) -> Value:
    """Returns a number calculated from others: int32 or float32, the others all of one of the two."""
    row = CALCULATIONS[e.fn]
    dtype: array.DType = "i32" if e.type.kind == "int" else "f32"
    of: array.DType = "i32" if dtype == "i32" and all(a.type.kind == "int" for a in e.args) else "f32"
    args = [as_dtype(lower(a, scope, w), of) for a in e.args]
    if not row.array[0].isalpha():
        return binary(row.array, args[0], args[1], dtype) if len(args) == 2 else _signed(row, args[0])
    if all(a.literal for a in args) and row.rounding is None:
        return literal(row.fold(*(float32(a.number) if of != dtype else a.number for a in args)), dtype)
    if row.least == row.most:
        return as_dtype(_called(row.array, args, of), dtype)
    return reduce(lambda one, other: _called(row.array, [one, other], dtype), args)


def _signed(row: Calculation, value: Value) -> Value:
    """Returns a number behind a sign."""
    if value.literal:
        return literal(row.fold(value.number), value.dtype)
    return replace(value, node=array.Unary(row.array, value.node))


def _called(function: str, args: list[Value], dtype: array.DType) -> Value:
    """Returns what a function of arrays makes of numbers."""
    axes = union(*(a.axes for a in args))
    return Value(array.call(function, *(aligned(a, axes) for a in args)), dtype, axes)


def test(e: ir.Compare | ir.Same | ir.InRange | ir.InWords | ir.InSet | ir.IsEmpty, scope: IterationScope, w: Writer) -> Value:
    """Returns a comparison."""
    match e:
        case ir.Compare():
            left, right = _numbers((e.left, e.right), scope, w)
            return binary(e.fn, left, right, "bool")
        case ir.Same():
            if is_cell(e.left):
                return binary("==", cell_values.kept(e.left, scope, w), cell_values.kept(e.right, scope, w), "bool")
            left, right = lower(e.left, scope, w), lower(e.right, scope, w)
            if e.left.type.kind == "word":
                left, right = _common_words(e, left, right, w)
            return binary("==", left, right, "bool")
        case ir.InRange():
            value, low, high = _numbers((e.value, e.low, e.high), scope, w)
            return both(binary(">=", value, low, "bool"), binary("<=", value, high, "bool")) or TRUE
        case ir.InWords():
            return _is_one_of(lower(e.value, scope, w), e.words, e.value, w)
        case ir.InSet():
            container, value = lower(e.container, scope, w), lower(e.value, scope, w)
            if container.levels:
                axes = union(container.axes, value.axes)
                return Value(array.call("has_member", aligned_row(container, axes), aligned(value, axes)), "bool", axes)
            bit = binary(">>", as_dtype(container, "u32"), as_dtype(value, "u32"), "u32")
            return binary("!=", binary("&", bit, literal(1, "u32"), "u32"), literal(0, "u32"), "bool")
        case ir.IsEmpty():
            container = lower(e.container, scope, w)
            empty = binary("==", container, literal(0, "u32"), "bool")
            return replace(empty, node=array.Reduce("all", empty.node, (-1,)), levels=0) if container.levels else empty
        case _:
            assert_never(e)


def _numbers(expressions: tuple[ir.Expr, ...], scope: IterationScope, w: Writer) -> list[Value]:
    """Returns numbers to be compared: reals if one of them is one."""
    values = [lower(x, scope, w) for x in expressions]
    return [as_dtype(v, "f32" if any(o.dtype == "f32" for o in values) else "i32") for v in values]


def _is_one_of(value: Value, words: tuple[str, ...], what: ir.Expr, w: Writer) -> Value:
    """Returns whether a word is one of some."""
    declared = declared_by(what, w)
    return either([binary("==", value, w.module.word(x, what.type.words, declared), "bool") for x in words])


def _common_words(e: ir.Same, left: Value, right: Value, w: Writer) -> tuple[Value, Value]:
    a, b = e.left.type.words, e.right.type.words
    if isinstance(e.right, ir.Word):
        return left, to_words(right, b, a, w, declared_by(e.left, w))
    if isinstance(e.left, ir.Word):
        return to_words(left, a, b, w, declared_by(e.right, w)), right
    union_ = tuple(dict.fromkeys(a + b))
    return to_words(left, a, union_, w), to_words(right, b, union_, w)


def whereabouts(e: ir.Chose | ir.Unoccupied | ir.StandsOn, scope: IterationScope, w: Writer) -> Value:
    """Returns what an agent chose, whether a cell is free, whether an agent stands on a kind."""
    match e:
        case ir.Chose():
            return binary("==", chosen.action_of(e.agent, scope), Value(w.module.action(e.action), "i32"), "bool")
        case ir.Unoccupied():
            cell = owner(e.cell, scope, w)
            assert isinstance(cell, CellVar)
            return invert(state_reads.occupied(cell, w))
        case ir.StandsOn():
            who = owner(e.agent, scope, w)
            assert isinstance(who, AgentVar)
            return state_reads.site_under(who, e.kinds, w)[1]
        case _:
            assert_never(e)


def case(e: ir.Case, scope: IterationScope, w: Writer) -> Value:
    """Returns nested selections, the last arm for all that is left."""
    name = condition_name(e.subject, w.module.game)
    subject = w.keep(name or "subject", lower(e.subject, scope, w))
    dtypes: dict[str, array.DType] = {"int": "i32", "real": "f32", "word": "u8", "condition": "bool"}
    values = []
    for arm in e.arms:
        value = lower(arm.value, scope, w)
        if e.type.kind == "word":
            value = to_words(value, arm.value.type.words, e.type.words, w)
        values.append(as_dtype(value, dtypes[e.type.kind]))
    tests = [_arm_test(e, arm, subject, w) for arm in e.arms[:-1]]
    return first_of(list(zip(tests, values[:-1], strict=True)), values[-1], w)


def first_of(arms: list[tuple[Value, Value]], otherwise: Value, w: Writer) -> Value:
    """Returns the value of the first arm whose test holds; of many arms a few at a time, so that brackets do not pile up."""
    result = otherwise
    for number, (test, value) in enumerate(reversed(arms)):
        result = w.keep("chosen", result) if number and number % ARMS == 0 else result
        result = select(test, value, result)
    return result


def _arm_test(e: ir.Case, arm: ir.Arm, subject: Value, w: Writer) -> Value:
    if e.subject.type.kind == "condition":
        return subject if arm.words == ("yes",) else invert(subject)
    if arm.words:
        return _is_one_of(subject, arm.words, e.subject, w)
    if arm.low is not None and arm.low == arm.high:
        return binary("==", subject, literal(arm.low, "i32"), "bool")
    low = None if arm.low is None else binary(">=", subject, literal(arm.low, "i32"), "bool")
    high = None if arm.high is None else binary("<=", subject, literal(arm.high, "i32"), "bool")
    return both(low, high) or TRUE
