"""Lowers expressions to array expressions."""

from dataclasses import replace
from functools import reduce
from typing import Literal as OneOf
from typing import assert_never

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.ir.names import param_attribute
from sjdsl.compiler.ir.operations import CALCULATIONS, REDUCTIONS
from sjdsl.compiler.lower import chosen, state_reads
from sjdsl.compiler.lower.aggregates import extreme, total
from sjdsl.compiler.lower.axes import (
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
from sjdsl.compiler.lower.condition_names import condition_name, value_name
from sjdsl.compiler.lower.entries import aligned_row, entry, to_words, words_first, words_last
from sjdsl.compiler.lower.scope import AgentVar, CellVar, IterationScope, Variable
from sjdsl.compiler.lower.writer import NOBODY, Writer
from sjdsl.compiler.program import expressions as array

LARGE = 8  # nodes of a defined condition from which on it keeps its name
ARMS = 4  # of one nested selection
VALUE_DTYPES: dict[str, array.DType] = {
    "int": "i32",
    "real": "f32",
    "word": "u8",
    "condition": "bool",
}


def lower(e: ir.Expr, scope: IterationScope, w: Writer) -> Value:
    """Returns the array that an expression is for all instances of a scope at once."""
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
            return state_reads.no_cell(w)
        case ir.ParamRef():
            return Value(
                array.path(f"params.{param_attribute(e.name)}"),
                VALUE_DTYPES[e.type.kind],
                (),
                len(e.type.by),
            )
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
        case ir.Compare():
            left, right = _numbers((e.left, e.right), scope, w)
            return binary(e.fn, left, right, "bool")
        case ir.Same():
            return same(e, scope, w)
        case ir.InRange():
            value, low, high = _numbers((e.value, e.low, e.high), scope, w)
            return both(binary(">=", value, low, "bool"), binary("<=", value, high, "bool"))
        case ir.InWords():
            return _is_one_of(lower(e.value, scope, w), e.words, e.value, w)
        case ir.InSet():
            container, value = lower(e.container, scope, w), lower(e.value, scope, w)
            if container.levels:
                axes = union(container.axes, value.axes)
                return Value(
                    array.call("has_member", aligned_row(container, axes), aligned(value, axes)),
                    "bool",
                    axes,
                )
            bit = binary(">>", as_dtype(container, "u32"), as_dtype(value, "u32"), "u32")
            return binary(
                "!=", binary("&", bit, literal(1, "u32"), "u32"), literal(0, "u32"), "bool"
            )
        case ir.IsEmpty():
            container = lower(e.container, scope, w)
            empty = binary("==", container, literal(0, "u32"), "bool")
            return (
                replace(empty, node=array.reduction("all", empty.node, (-1,)), levels=0)
                if container.levels
                else empty
            )
        case ir.Chose():
            return binary(
                "==",
                chosen.action_of(e.agent, scope),
                Value(w.module.action(e.action), "i32"),
                "bool",
            )
        case ir.Unoccupied():
            cell = owner(e.cell, scope, w)
            assert isinstance(cell, CellVar)
            return invert(state_reads.occupied(cell, w))
        case ir.StandsOn():
            return state_reads.site_under(agent(e.agent, scope, w), e.kinds, w)[1]
        case ir.StandsAt():
            return stands_at(e, scope, w)
        case ir.ChoseWith():
            return chosen.chose_with(e, scope, w)
        case ir.ArgumentOf():
            return chosen.argument_of(e, scope, w)
        case ir.Not():
            return invert(lower(e.value, scope, w))
        case ir.Logic():
            parts = [lower(a, scope, w) for a in e.args]
            return either(parts) if e.fn == "or" else both(*parts)
        case ir.Count() | ir.Sum():
            return total(e, scope, w)
        case ir.Extreme():
            return extreme(e, scope, w)
        case ir.SumRow():
            row, reduction = lower(e.row, scope, w), REDUCTIONS[e.fn]
            if reduction.adds and w.exact and row.dtype == "f32":
                return replace(
                    row,
                    node=array.call("exact_sum", row.node, array.Literal(len(row.axes))),
                    levels=0,
                )
            node = summed(row.node, row.dtype) if reduction.adds else row.node
            return replace(
                row,
                node=array.reduction(
                    reduction.array, node, (-1,), row.dtype if reduction.adds else None
                ),
                levels=0,
            )
        case ir.Lowest():
            with w.deciding():
                row = lower(e.row, scope, w)
            return replace(
                row,
                node=array.call("highest" if e.last else "lowest", row.node),
                dtype="u8",
                levels=0,
            )
        case ir.Mix():
            row, name = lower(e.row, scope, w), value_name(e.row)
            shares = array.call("exact_mix" if w.exact else "mix", row.node)
            return w.keep(f"{name}_shares" if name else "shares", Value(shares, "f32", row.axes, 1))
        case ir.ShiftRow():
            return shift(e, scope, w)
        case ir.Case():
            return case(e, scope, w)
        case ir.Named():  # short conditions are written out, all else is kept under its name for all who read it
            value = lower(e.value, scope, w)
            return (
                value
                if value.dtype == "bool" and len(list(walk(value.node))) < LARGE
                else w.keep(e.name, value)
            )
        case ir.Narrowed():
            return to_words(lower(e.value, scope, w), e.value.type.words, e.type.words, w)
        case ir.Before():  # of the state before the step, which a function of checks is given beside the state
            here, w.state = w.state, "before"
            value = lower(e.value, scope, w)
            w.state = here
            return value
        case ir.EventTotal() | ir.MatrixClass():
            raise AssertionError(e)
        case _:
            assert_never(e)


def nobody(w: Writer) -> Value:
    """Returns the number that stands for no agent."""
    return Value(w.module.number("nobody", NOBODY, "in place of an agent's number"), "i32")


def shift(e: ir.ShiftRow, scope: IterationScope, w: Writer) -> Value:
    """Returns a row with its entries moved on."""
    row, filler = lower(e.row, scope, w), lower(e.filler, scope, w)
    match e.type.kind:
        case "word":
            filler = to_words(filler, e.filler.type.words, e.type.words, w)
        case "agents":
            filler = literal(0, row.dtype) if isinstance(e.filler, ir.Nobody) else filler
        case "cell":
            filler = state_reads.kept_cell(e.filler, scope, w)
        case "int" | "real":
            row, filler = (
                as_dtype(part, "i32" if e.type.kind == "int" else "f32") for part in (row, filler)
            )
        case _:
            pass
    axes = union(row.axes, filler.axes)
    fill = array.scalar(filler.node, row.dtype) if filler.literal else aligned_row(filler, axes)
    if row.levels > 1:  # of large sets
        fill = fill if filler.literal else words_first(fill)
        moved = words_last(
            array.call("shifted", words_first(aligned_row(row, axes)), array.Literal(e.by), fill)
        )
    else:
        moved = array.call("shifted", aligned_row(row, axes), array.Literal(e.by), fill)
    return replace(row, node=moved, axes=axes)


def real(e: ir.Expr, scope: IterationScope, w: Writer) -> Value:
    """Returns a number as float32."""
    return as_dtype(w.value(e, scope), "f32")


def owner(e: ir.Expr, scope: IterationScope, w: Writer) -> Variable:
    """Returns the variable whose field is read: one in scope, or the agent an expression gives."""
    if isinstance(e, ir.Member):
        return scope.variables[e.name]
    return (
        state_reads.held_cell(e, e.type.kinds, scope, w)
        if e.type.kind == "cell"
        else AgentVar(w.value(e, scope))
    )


def agent(e: ir.Expr, scope: IterationScope, w: Writer) -> AgentVar:
    """Returns the agent or mover that an expression is."""
    who = owner(e, scope, w)
    assert isinstance(who, AgentVar), e
    return who


def is_cell(e: ir.Expr) -> bool:
    """Returns whether an expression is a cell: a variable, or a value."""
    return e.type.kind == "cell" or (isinstance(e, ir.Member) and e.sort.what == "cell")


def declared_by(e: ir.Expr, w: Writer) -> ir.VarField | None:
    """Returns the field that an expression is a value of, if it is nothing but that."""
    while isinstance(e, ir.At | ir.Narrowed):
        e = e.row if isinstance(e, ir.At) else e.value
    return w.module.field(e) if isinstance(e, ir.FieldRead) else None


def attribute(e: ir.Attribute, scope: IterationScope, w: Writer) -> Value:
    """Returns a read-only fact about an agent or a cell."""
    who = owner(e.owner, scope, w)
    if e.name in ("row", "col"):
        placed = _in_frame(who, e.name, w)
        return replace(
            placed, node=array.Binary("-", placed.node, array.Literal(w.module.layout.pad, "PAD"))
        )
    assert isinstance(who, AgentVar)
    match e.name:
        case "index":
            return who.index
        case "heading":
            return as_dtype(state_reads.heading(who, w), "u8")
        case "moved":
            return state_reads.moved(who, w)
        case "away":
            return invert(state_reads.present(who, w))
        case _:
            raise AssertionError(e)


def _in_frame(who: Variable, side: OneOf["row", "col"], w: Writer) -> Value:
    """Returns the row or column of an agent or a cell in the frame around the map."""
    at = state_reads.position(who, w) if isinstance(who, AgentVar) else state_reads.cell(who, w)
    cols = w.module.number("frame_cols", w.module.layout.cols)
    return w.keep(
        side, Value(array.Binary("//" if side == "row" else "%", at.node, cols), "i32", at.axes)
    )


def distance(e: ir.Distance, scope: IterationScope, w: Writer) -> Value:
    """Returns the steps between two agents or cells, once for all who ask in this function."""
    a, b = owner(e.left, scope, w), owner(e.right, scope, w)
    for one, other in ((a, b), (b, a)):
        if (
            isinstance(one, CellVar)
            and one.seen
            and isinstance(other, AgentVar)
            and other.axis == one.seen[0]
        ):
            return state_reads.seen_steps(w, *one.seen)
    sides = [
        binary("-", _in_frame(a, side, w), _in_frame(b, side, w), "i32") for side in ("row", "col")
    ]
    if w.module.layout.wraps:
        lengths = (w.module.layout.height, w.module.layout.width)
        sides = [
            replace(x, node=array.call("shorter_way", x.node, array.Literal(n)))
            for x, n in zip(sides, lengths, strict=True)
        ]
    rows, cols = (replace(side, node=array.call("jnp.abs", side.node)) for side in sides)
    return w.keep("distance", binary("+", rows, cols, "i32"))


def stands_at(e: ir.StandsAt, scope: IterationScope, w: Writer) -> Value:
    """Returns whether an agent or a mover is on a cell. Who is away is on cell 0 of the frame, which is beside the map."""
    cell = owner(e.cell, scope, w)
    assert isinstance(cell, CellVar)
    return binary(
        "==", state_reads.position(agent(e.agent, scope, w), w), state_reads.cell(cell, w), "bool"
    )


def arithmetic(e: ir.Arithmetic, scope: IterationScope, w: Writer) -> Value:
    """Returns a number calculated from others: int32 or float32, the others all of one of the two."""
    row = CALCULATIONS[e.fn]
    dtype: array.DType = "i32" if e.type.kind == "int" else "f32"
    of: array.DType = (
        "i32" if dtype == "i32" and all(a.type.kind == "int" for a in e.args) else "f32"
    )
    with w.deciding(row.kind == "whole"):
        args = [as_dtype(lower(a, scope, w), of) for a in e.args]
    exact = w.exact and of == "f32" and not all(a.literal for a in args)
    if exact and (row.rounding is not None or row.exact):
        args = [operand(a, value, w) for a, value in zip(e.args, args, strict=True)]
    if exact and row.exact:
        return _called(row.exact, args, dtype)
    if not row.array[0].isalpha():
        if len(args) == 2:
            return binary(row.array, args[0], args[1], dtype)
        return (
            replace(args[0], node=array.Unary(row.array, args[0].node))
            if not args[0].literal
            else literal(row.fold(args[0].number), of)
        )
    if all(a.literal for a in args) and row.rounding is None:
        return literal(
            row.fold(*(float32(a.number) if of != dtype else a.number for a in args)), dtype
        )
    if row.least == row.most:
        return as_dtype(_called(row.array, args, of), dtype)
    return reduce(lambda one, other: _called(row.array, [one, other], dtype), args)


def operand(e: ir.Expr, value: Value, w: Writer) -> Value:
    """Returns a real that arithmetic reads. If it decides something, it is rounded before; numbers and parameters are anyway."""
    if not w.exact or value.dtype != "f32" or value.literal or _is_given(e):
        return value
    return replace(value, node=array.call("exactly", value.node))


def _is_given(e: ir.Expr) -> bool:
    """Returns whether no arithmetic of reals has made a number: it is written, a parameter, or a whole number."""
    match e:
        case ir.Named():
            return _is_given(e.value)
        case ir.At() if e.key.type.kind != "mix":
            return _is_given(e.row)
        case _:
            return isinstance(e, ir.Number | ir.ParamRef) or e.type.kind == "int"


def _called(function: str, args: list[Value], dtype: array.DType) -> Value:
    """Returns what a function of arrays makes of numbers."""
    axes = union(*(a.axes for a in args))
    return Value(array.call(function, *(aligned(a, axes) for a in args)), dtype, axes)


def same(e: ir.Same, scope: IterationScope, w: Writer) -> Value:
    """Returns whether two cells, agents or words are the same."""
    if is_cell(e.left):
        return binary(
            "==",
            state_reads.kept_cell(e.left, scope, w),
            state_reads.kept_cell(e.right, scope, w),
            "bool",
        )
    left, right = lower(e.left, scope, w), lower(e.right, scope, w)
    if e.left.type.kind == "word":
        a, b = e.left.type.words, e.right.type.words
        if isinstance(e.right, ir.Word):
            right = to_words(right, b, a, w, declared_by(e.left, w))
        elif isinstance(e.left, ir.Word):
            left = to_words(left, a, b, w, declared_by(e.right, w))
        else:
            words = tuple(dict.fromkeys(a + b))
            left, right = to_words(left, a, words, w), to_words(right, b, words, w)
    return binary("==", left, right, "bool")


def _numbers(expressions: tuple[ir.Expr, ...], scope: IterationScope, w: Writer) -> list[Value]:
    """Returns numbers to be compared: reals if one of them is one."""
    with w.deciding():
        values = [lower(x, scope, w) for x in expressions]
    return [as_dtype(v, "f32" if any(o.dtype == "f32" for o in values) else "i32") for v in values]


def _is_one_of(value: Value, words: tuple[str, ...], what: ir.Expr, w: Writer) -> Value:
    """Returns whether a word is one of some."""
    declared = declared_by(what, w)
    return either(
        [binary("==", value, w.module.word(x, what.type.words, declared), "bool") for x in words]
    )


def case(e: ir.Case, scope: IterationScope, w: Writer) -> Value:
    """Returns nested selections, the last arm for all that is left."""
    name = condition_name(e.subject, w.module.game)
    subject = w.keep(name or "subject", lower(e.subject, scope, w))
    values = []
    for arm in e.arms:
        value = lower(arm.value, scope, w)
        if e.type.kind == "word":
            value = to_words(value, arm.value.type.words, e.type.words, w)
        values.append(as_dtype(value, VALUE_DTYPES[e.type.kind]))
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
    low = TRUE if arm.low is None else binary(">=", subject, literal(arm.low, "i32"), "bool")
    high = TRUE if arm.high is None else binary("<=", subject, literal(arm.high, "i32"), "bool")
    return both(low, high)
