"""Lowers expressions to array expressions."""

from dataclasses import replace
from functools import partial, reduce
from operator import and_, or_
from typing import Literal as OneOf
from typing import assert_never

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.ir.names import param_attribute
from sjdsl.compiler.ir.operations import CALCULATIONS, REDUCTIONS
from sjdsl.compiler.lower import chosen, state_reads
from sjdsl.compiler.lower.aggregates import count, extreme, total
from sjdsl.compiler.lower.axes import (
    FALSE,
    TRUE,
    Value,
    aligned,
    as_dtype,
    axes_of,
    binary,
    called,
    float32,
    literal,
    row_aligned,
    select,
    summed,
)
from sjdsl.compiler.lower.condition_names import condition_name, value_name
from sjdsl.compiler.lower.entries import entry, numbers_first, numbers_last, to_words
from sjdsl.compiler.lower.scope import AgentVar, CellVar, IterationScope, Variable
from sjdsl.compiler.lower.writer import NOBODY, Writer
from sjdsl.compiler.program.expressions import (
    Binary,
    DType,
    Expression,
    Unary,
    call,
    path,
    reduction,
    scalar,
)

LARGE = 8  # nodes of a `define`d condition from which on it becomes a variable of generated code
ARMS = 4  # selections inside each other in one expression
VALUE_DTYPES: dict[str, DType] = {
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
            node = path(f"params.{param_attribute(e.name)}")
            return Value(node, VALUE_DTYPES[e.type.kind], (), len(e.type.indexed_by))
        case ir.Member():
            return scope.variables[e.name].number
        case ir.Local():
            return scope.locals[e.name]
        case ir.FieldRead():
            holder = None if e.owner is None else owner(e.owner, scope, w)
            return state_reads.field(e, holder, w)
        case ir.Attribute():
            return attribute(e, scope, w)
        case ir.Distance():
            return distance(e, scope, w)
        case ir.Bearing():
            return bearing(e, scope, w)
        case ir.At():
            return entry(e, scope, w)
        case ir.Step():
            return Value(w.stored("step"), "i32")
        case ir.Arithmetic():
            return arithmetic(e, scope, w)
        case ir.Compare():
            left, right = _numbers((e.left, e.right), scope, w)
            return binary(e.fn, left, right)
        case ir.Same():
            return same(e, scope, w)
        case ir.InRange():
            value, low, high = _numbers((e.value, e.low, e.high), scope, w)
            return (value >= low) & (value <= high)
        case ir.InWords():
            return _is_one_of(lower(e.value, scope, w), e.words, e.value, w)
        case ir.InSet():
            return in_set(e, scope, w)
        case ir.IsEmpty():
            empty = lower(e.container, scope, w).eq(0)
            if not empty.row_dims:
                return empty
            return replace(empty, node=reduction("all", empty.node, (-1,)), row_dims=0)
        case ir.Chose():
            return chosen.action_of(e.agent, scope).eq(w.module.action(e.action))
        case ir.Unoccupied():
            cell = owner(e.cell, scope, w)
            assert isinstance(cell, CellVar)
            return ~state_reads.occupied(cell, w)
        case ir.StandsOn():
            who = agent(e.agent, scope, w)
            _, is_on = state_reads.site_under(who, e.kinds, w)
            return is_on
        case ir.StandsAt():
            # One that is away is on cell 0 of the frame, which is no cell of the map.
            position = state_reads.location(owner(e.agent, scope, w), w)
            return position.eq(state_reads.location(owner(e.cell, scope, w), w))
        case ir.ChoseWith():
            return chosen.chose_with(e, scope, w)
        case ir.ArgumentOf():
            return chosen.argument_of(e, scope, w)
        case ir.Not():
            return ~lower(e.value, scope, w)
        case ir.Logic():
            parts = [lower(a, scope, w) for a in e.args]
            return reduce(or_ if e.fn == "or" else and_, parts)
        case ir.Count():
            return count(e, scope, w)
        case ir.Sum():
            return total(e, scope, w)
        case ir.Extreme():
            return extreme(e, scope, w)
        case ir.SumRow():
            return sum_row(e, scope, w)
        case ir.Lowest():
            with w.deciding():
                row = lower(e.row, scope, w)
            node = call("highest" if e.last else "lowest", row.node)
            return replace(row, node=node, dtype="u8", row_dims=0)
        case ir.Mix():
            row = lower(e.row, scope, w)
            shares = call("exact_mix" if w.exact else "mix", row.node)
            name = f"{value_name(e.row)}_shares".strip("_")
            return w.keep(name, Value(shares, "f32", row.axes, 1))
        case ir.ShiftRow():
            return shift(e, scope, w)
        case ir.Case():
            return case(e, scope, w)
        case ir.Named():
            value = lower(e.value, scope, w)
            is_short = value.dtype == "bool" and len(list(walk(value.node))) < LARGE
            return value if is_short else w.keep(e.name, value)
        case ir.Narrowed():
            word = lower(e.value, scope, w)
            return to_words(word, e.value.type.words, e.type.words, w)
        case ir.Before():
            with w.reading("before"):  # a parameter of the functions of checks
                return lower(e.value, scope, w)
        case ir.EventTotal() | ir.MatrixClass():
            raise AssertionError(e)
        case _:
            assert_never(e)


def nobody(w: Writer) -> Value:
    """Returns the number that stands for no agent."""
    return Value(w.module.number("nobody", NOBODY, "in place of an agent's number"), "i32")


def in_set(e: ir.InSet, scope: IterationScope, w: Writer) -> Value:
    """Returns whether an agent is in a set, which is kept as bits."""
    container = lower(e.container, scope, w)
    value = lower(e.value, scope, w)
    if container.row_dims:
        axes = axes_of(container, value)
        node = call("has_member", row_aligned(container, axes), aligned(value, axes))
        return Value(node, "bool", axes)
    bits = as_dtype(container, "u32")  # bit i is 1 if agent i is in the set
    bits_from_agent = bits >> as_dtype(value, "u32")
    return (bits_from_agent & 1).ne(0)


def sum_row(e: ir.SumRow, scope: IterationScope, w: Writer) -> Value:
    """Returns the sum or an extreme of all entries of a row."""
    row = lower(e.row, scope, w)
    folding = REDUCTIONS[e.fn]
    node: Expression
    if not folding.adds:
        node = reduction(folding.array, row.node, (-1,), None)
    elif w.exact and row.dtype == "f32":
        node = call("exact_sum", row.node, len(row.axes))
    else:
        node = reduction(folding.array, summed(row.node, row.dtype), (-1,), row.dtype)
    return replace(row, node=node, row_dims=0)


def shift(e: ir.ShiftRow, scope: IterationScope, w: Writer) -> Value:
    """Returns a row whose entries are moved by some places, with a filler in those left."""
    row = lower(e.row, scope, w)
    filler = lower(e.filler, scope, w)
    match e.type.kind:
        case "word":
            filler = to_words(filler, e.filler.type.words, e.type.words, w)
        case "agents":
            if isinstance(e.filler, ir.Nobody):
                filler = literal(0, row.dtype)
        case "cell":
            filler = state_reads.kept_cell(e.filler, scope, w)
        case "int" | "real" as kind:
            row = as_dtype(row, VALUE_DTYPES[kind])
            filler = as_dtype(filler, VALUE_DTYPES[kind])
        case _:
            pass
    axes = axes_of(row, filler)
    entries = row_aligned(row, axes)
    fill = scalar(filler.node, row.dtype) if filler.literal else row_aligned(filler, axes)
    if row.row_dims == 1:
        return replace(row, node=call("shifted", entries, e.by, fill), axes=axes)
    if not filler.literal:
        fill = numbers_first(fill)
    moved = call("shifted", numbers_first(entries), e.by, fill)  # rows of large sets
    return replace(row, node=numbers_last(moved), axes=axes)


def real(e: ir.Expr, scope: IterationScope, w: Writer) -> Value:
    """Returns a number as float32."""
    return as_dtype(w.value(e, scope), "f32")


def owner(e: ir.Expr, scope: IterationScope, w: Writer) -> Variable:
    """Returns the agents or cells that an expression is: of a variable, or computed numbers."""
    if isinstance(e, ir.Member):
        return scope.variables[e.name]
    if e.type.kind == "cell":
        return state_reads.held_cell(e, e.type.kinds, scope, w)
    return AgentVar(w.value(e, scope))


def agent(e: ir.Expr, scope: IterationScope, w: Writer) -> AgentVar:
    """Returns the agent or mover that an expression is."""
    who = owner(e, scope, w)
    assert isinstance(who, AgentVar), e
    return who


def is_cell(e: ir.Expr) -> bool:
    """Returns whether an expression is a cell: a variable, or a value."""
    return e.type.kind == "cell" or (isinstance(e, ir.Member) and e.entity_type.what == "cell")


def declared_by(e: ir.Expr, w: Writer) -> ir.VarField | None:
    """Returns the field that an expression is a value of, None for other values."""
    while isinstance(e, ir.At | ir.Narrowed):
        e = e.row if isinstance(e, ir.At) else e.value
    return w.module.field(e) if isinstance(e, ir.FieldRead) else None


def attribute(e: ir.Attribute, scope: IterationScope, w: Writer) -> Value:
    """Returns a read-only attribute of an agent, a mover or a cell."""
    variable = owner(e.owner, scope, w)
    if e.name in ("row", "col"):
        in_frame = _in_frame(variable, e.name, w)
        return replace(in_frame, node=in_frame.node - w.module.pad)
    assert isinstance(variable, AgentVar)
    match e.name:
        case "index":
            return variable.number
        case "heading":
            return as_dtype(state_reads.heading(variable, w), "u8")
        case "moved":
            return state_reads.moved(variable, w)
        case "away":
            return ~state_reads.present(variable, w)
        case _:
            raise AssertionError(e)


def _in_frame(variable: Variable, side: OneOf["row", "col"], w: Writer) -> Value:
    """Returns the row or column of an agent or a cell in the frame, as it is after padding."""
    at = state_reads.location(variable, w)
    op = "//" if side == "row" else "%"
    return w.keep(side, replace(at, node=Binary(op, at.node, w.module.frame_cols)))


def distance(e: ir.Distance, scope: IterationScope, w: Writer) -> Value:
    """Returns the steps between two agents or cells."""
    a = owner(e.left, scope, w)
    b = owner(e.right, scope, w)
    for cell, observer in ((a, b), (b, a)):
        if isinstance(cell, CellVar) and cell.seen and observer.axis == cell.seen[0]:
            return state_reads.seen_steps(w, *cell.seen)
    rows = _in_frame(a, "row", w) - _in_frame(b, "row", w)
    cols = _in_frame(a, "col", w) - _in_frame(b, "col", w)
    layout = w.layout
    if layout.wraps:
        rows = called("shorter_way", rows, layout.height)
        cols = called("shorter_way", cols, layout.width)
    return w.keep("distance", called("jnp.abs", rows) + called("jnp.abs", cols))


def bearing(e: ir.Bearing, scope: IterationScope, w: Writer) -> Value:
    """Returns `steps_ahead(a, b)` or `steps_right(a, b)`: how far b is ahead of a, or to its right.

    It is negative for what is behind, or to the left.
    """
    a = agent(e.left, scope, w)
    b = owner(e.right, scope, w)
    row_of_a = _in_frame(a, "row", w)
    row_of_b = _in_frame(b, "row", w)
    col_of_a = _in_frame(a, "col", w)
    col_of_b = _in_frame(b, "col", w)
    layout = w.layout
    steps_to = [  # the north, east, south and west
        (row_of_a - row_of_b, layout.height),
        (col_of_b - col_of_a, layout.width),
        (row_of_b - row_of_a, layout.height),
        (col_of_a - col_of_b, layout.width),
    ]
    if e.fn == "steps_right":  # to the right of north is east, and so on
        steps_to = [*steps_to[1:], steps_to[0]]
    by_heading = []
    for steps, length in steps_to:
        by_heading.append(called("shorter_way", steps, length) if layout.wraps else steps)
    heading = w.keep("heading", state_reads.heading(a, w))
    arms = [(heading.eq(number), steps) for number, steps in enumerate(by_heading[:3])]
    return w.keep(e.fn, first_of(arms, by_heading[3], w))


def arithmetic(e: ir.Arithmetic, scope: IterationScope, w: Writer) -> Value:
    """Returns an operation on numbers, which are all int32 or all float32.

    Of literals alone the result is computed now.
    """
    operation = CALCULATIONS[e.fn]
    dtype = VALUE_DTYPES[e.type.kind]
    is_whole = dtype == "i32" and all(a.type.kind == "int" for a in e.args)
    args_dtype: DType = "i32" if is_whole else "f32"
    with w.deciding(operation.kind == "whole"):
        args = [as_dtype(lower(a, scope, w), args_dtype) for a in e.args]
    are_literal = all(a.literal for a in args)
    # What decides something is computed as written, so by a kernel that no compiler rearranges.
    if w.exact and not is_whole and not are_literal:
        if operation.rounding is not None or operation.exact:
            args = [operand(a, value, w) for a, value in zip(e.args, args, strict=True)]
        if operation.exact:
            return called(operation.exact, *args, dtype=dtype)
    is_operator = not operation.array[0].isalpha()
    if is_operator and len(args) == 2:
        return binary(operation.array, args[0], args[1])
    if is_operator and are_literal:
        return literal(operation.fold(args[0].number), args_dtype)
    if is_operator:
        return replace(args[0], node=Unary(operation.array, args[0].node))
    is_rounded = operation.rounding is not None or operation.exact
    if are_literal and (is_whole or not is_rounded):
        numbers = [a.number if args_dtype == dtype else float32(a.number) for a in args]
        return literal(operation.fold(*numbers), dtype)
    # A function of arrays; one of any number of arguments takes two at a time.
    if operation.least == operation.most:
        return as_dtype(called(operation.array, *args), dtype)
    return reduce(partial(called, operation.array), args)


def operand(e: ir.Expr, value: Value, w: Writer) -> Value:
    """Returns an operand of arithmetic; if it decides something, it is rounded to float32 first.

    Written numbers and parameters are float32 anyway.
    """
    if not w.exact or value.dtype != "f32" or value.literal or _is_unrounded(e):
        return value
    return called("exactly", value)


def _is_unrounded(e: ir.Expr) -> bool:
    """Returns whether an expression is exact in float32 already: it isn't computed from reals."""
    match e:
        case ir.Named():
            return _is_unrounded(e.value)
        case ir.At() if e.key.type.kind != "mix":
            return _is_unrounded(e.row)
        case _:
            return isinstance(e, ir.Number | ir.ParamRef) or e.type.kind == "int"


def same(e: ir.Same, scope: IterationScope, w: Writer) -> Value:
    """Returns whether two cells, agents or words are the same."""
    if is_cell(e.left):
        left = state_reads.kept_cell(e.left, scope, w)
        right = state_reads.kept_cell(e.right, scope, w)
        return left.eq(right)
    left = lower(e.left, scope, w)
    right = lower(e.right, scope, w)
    if e.left.type.kind == "word":
        left_words = e.left.type.words
        right_words = e.right.type.words
        if isinstance(e.right, ir.Word):
            right = to_words(right, right_words, left_words, w, declared_by(e.left, w))
        elif isinstance(e.left, ir.Word):
            left = to_words(left, left_words, right_words, w, declared_by(e.right, w))
        else:
            words = tuple(dict.fromkeys(left_words + right_words))
            left = to_words(left, left_words, words, w)
            right = to_words(right, right_words, words, w)
    return left.eq(right)


def _numbers(expressions: tuple[ir.Expr, ...], scope: IterationScope, w: Writer) -> list[Value]:
    """Returns numbers to be compared: reals if one of them is one."""
    with w.deciding():
        values = [lower(x, scope, w) for x in expressions]
    dtype: DType = "f32" if any(v.dtype == "f32" for v in values) else "i32"
    return [as_dtype(v, dtype) for v in values]


def _is_one_of(value: Value, words: tuple[str, ...], e: ir.Expr, w: Writer) -> Value:
    """Returns whether an enum value is one of `words`. e: the expression that has the value."""
    declared = declared_by(e, w)
    is_one = FALSE
    for word in words:
        number = w.module.word(word, e.type.words, declared)
        is_one = is_one | value.eq(number)
    return is_one


def case(e: ir.Case, scope: IterationScope, w: Writer) -> Value:
    """Returns `case w { red: a, otherwise: b }`: nested selections, the last for what is left."""
    name = condition_name(e.subject, w.game)
    subject = w.keep(name or "subject", lower(e.subject, scope, w))
    *values, otherwise = [_arm_value(e, arm, scope, w) for arm in e.arms]
    tests = [_arm_test(e, arm, subject, w) for arm in e.arms[:-1]]
    arms = list(zip(tests, values, strict=True))
    return first_of(arms, otherwise, w)


def _arm_value(e: ir.Case, arm: ir.Arm, scope: IterationScope, w: Writer) -> Value:
    """Returns the value of an arm, as all arms of a `case` have it."""
    value = lower(arm.value, scope, w)
    if e.type.kind == "word":
        value = to_words(value, arm.value.type.words, e.type.words, w)
    return as_dtype(value, VALUE_DTYPES[e.type.kind])


def first_of(arms: list[tuple[Value, Value]], otherwise: Value, w: Writer) -> Value:
    """Returns the value of the first arm whose test holds.

    Of many arms a few at a time are kept under a name, so that brackets do not pile up.
    """
    result = otherwise
    for number, (test, value) in enumerate(reversed(arms)):
        if number and number % ARMS == 0:
            result = w.keep("chosen", result)
        result = select(test, value, result)
    return result


def _arm_test(e: ir.Case, arm: ir.Arm, subject: Value, w: Writer) -> Value:
    """Returns where the subject of a `case` is what an arm is for."""
    if e.subject.type.kind == "condition":
        return subject if arm.words == ("yes",) else ~subject
    if arm.words:
        return _is_one_of(subject, arm.words, e.subject, w)
    if arm.low is not None and arm.low == arm.high:
        return subject.eq(arm.low)
    low = TRUE if arm.low is None else subject >= arm.low
    high = TRUE if arm.high is None else subject <= arm.high
    return low & high
