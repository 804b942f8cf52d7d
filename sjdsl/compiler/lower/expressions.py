"""Lowers expressions to array expressions."""

from dataclasses import replace
from typing import assert_never

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import param_attribute
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import Axis, Value, aligned, as_dtype, binary, both, invert, literal, reduce, select, union, wrapped
from sjdsl.compiler.lower.scope import AgentVar, CellVar, Frame, NotSupported, Writer, iota

NOBODY = -1


def lower(e: ir.Expr, frame: Frame, w: Writer) -> Value:
    """Returns the array that an expression is for all instances of a place at once."""
    match e:
        case ir.Number():
            return literal(e.value, "i32" if e.type.kind == "int" else "f32")
        case ir.Word():
            return literal(e.type.words.index(e.value), "u8")
        case ir.Truth():
            return literal(e.value, "bool")
        case ir.Nobody():
            return literal(NOBODY, "i32")
        case ir.ParamRef():
            return _param(e)
        case ir.Member():
            return state_reads.member_number(frame.variables[e.name])
        case ir.Local():
            return frame.locals[e.name]
        case ir.FieldRead():
            return state_reads.field(e, None if e.owner is None else owner(e.owner, frame, w), w)
        case ir.Attribute():
            return attribute(e, frame, w)
        case ir.At():
            return entry(e, frame, w)
        case ir.Step():
            return Value("state.step", "i32")
        case ir.Arithmetic():
            return arithmetic(e, frame, w)
        case ir.Compare() | ir.Same() | ir.InRange() | ir.InWords() | ir.InSet() | ir.IsEmpty():
            return test(e, frame, w)
        case ir.Chose() | ir.Unoccupied() | ir.StandsOn():
            return whereabouts(e, frame, w)
        case ir.Not():
            return invert(lower(e.value, frame, w))
        case ir.Logic():
            return logic(e, frame, w)
        case ir.Count() | ir.Sum():
            from sjdsl.compiler.lower.aggregates import total

            return total(e, frame, w)
        case ir.SumRow() | ir.Lowest() | ir.Mix():
            return of_row(e, lower(e.row, frame, w))
        case ir.Case():
            return case(e, frame, w)
        case ir.Ramp():
            parts = [real(x, frame, w) for x in (e.value, e.zero_at, e.one_at)]
            axes = union(*(p.axes for p in parts))
            return Value(f"ramp({', '.join(aligned(p, axes) for p in parts)})", "f32", axes)
        case ir.Named():
            value = lower(e.value, frame, w)
            return value if value.dtype == "bool" else w.keep(e.name, value)
        case ir.Narrowed():
            return to_words(lower(e.value, frame, w), e.value.type.words, e.type.words)
        case ir.EventTotal() | ir.MatrixClass():
            raise AssertionError(e)
        case _:
            assert_never(e)


def of_row(e: ir.SumRow | ir.Lowest | ir.Mix, row: Value) -> Value:
    """Returns what is made of a whole row: its sum, the word of its lowest or highest entry, or the shares of its entries."""
    match e:
        case ir.SumRow():
            return replace(row, text=f"jnp.sum({row.text}, axis=-1, dtype={_dtype(row)})", levels=0)
        case ir.Lowest():
            return replace(row, text=f"{'highest' if e.last else 'lowest'}({row.text})", dtype="u8", levels=0)
        case ir.Mix():
            return Value(f"mix({row.text})", "f32", row.axes, 1)


def real(e: ir.Expr, frame: Frame, w: Writer) -> Value:
    """Returns a number as float32."""
    return as_dtype(lower(e, frame, w), "f32")


def owner(e: ir.Expr, frame: Frame, w: Writer) -> AgentVar | CellVar:
    """Returns the variable whose field is read: one in scope, or the agent an expression gives."""
    if isinstance(e, ir.Member):
        return frame.variables[e.name]
    return AgentVar(lower(e, frame, w))


def _dtype(value: Value) -> str:
    return {"f32": "jnp.float32", "i32": "jnp.int32"}[value.dtype]


def _param(e: ir.ParamRef) -> Value:
    dtype = {"int": "i32", "real": "f32", "word": "u8"}[e.type.kind]
    return Value(f"params.{param_attribute(e.name)}", dtype, (), len(e.type.by))


def attribute(e: ir.Attribute, frame: Frame, w: Writer) -> Value:
    """Returns a read-only fact about an agent or a cell."""
    who = owner(e.owner, frame, w)
    layout = w.module.layout
    if e.name in ("row", "col"):
        at = state_reads.position(who, w) if isinstance(who, AgentVar) else state_reads.cell(who, w)
        op = "//" if e.name == "row" else "%"
        return Value(f"{wrapped(at)} {op} {layout.cols} - {layout.pad}", "i32", at.axes)
    assert isinstance(who, AgentVar)
    match e.name:
        case "index":
            return state_reads.index_of(who)
        case "heading":
            return replace(state_reads.heading(who), text=f"{state_reads.heading(who).text}.astype(jnp.uint8)", dtype="u8")
        case "moved":
            stored = Value("state.moved", "bool")
            return (
                replace(stored, axes=(who.axis,))
                if who.axis
                else replace(stored, text=f"state.moved[{who.index.text}]", axes=who.index.axes)
            )
        case "away":
            here = state_reads.present(who, w)
            return literal(False, "bool") if here is None else invert(here)
        case _:
            raise AssertionError(e)


def entry(e: ir.At, frame: Frame, w: Writer) -> Value:
    """Returns one entry of a row or table: by a word, or the expected one by a mix."""
    row, key = lower(e.row, frame, w), lower(e.key, frame, w)
    if e.key.type.kind == "mix":
        return _expected(row, key)
    key = to_words(key, e.key.type.words, e.row.type.by[0])
    lead = ":, " * len(row.axes)
    if key.literal:
        return replace(row, text=f"{wrapped(row)}[{lead}{key.text}]", levels=row.levels - 1)
    if not row.axes:
        return Value(f"{wrapped(row)}[{key.text}]", row.dtype, key.axes, row.levels - 1)
    if row.levels != 1:
        instead = "write one of the words out with `case`"
        raise NotSupported("a table of several levels by words that differ from member to member", e.origin, instead)
    axes = union(row.axes, key.axes)
    return Value(f"entry({aligned_row(row, axes)}, {aligned(key, axes)})", row.dtype, axes)


def aligned_row(row: Value, axes: tuple[Axis, ...]) -> str:
    """Returns the text of a row lined up with axes, its levels last."""
    if row.axes == axes:
        return row.text
    return f"{wrapped(row)}[{', '.join([':' if a in row.axes else 'None' for a in axes])}]"


def _expected(row: Value, shares: Value) -> Value:
    axes = union(row.axes, shares.axes)
    tail = ", ".join(["None"] * (row.levels - 1))
    left = aligned_row(shares, axes)
    if tail:
        left = f"{wrapped(Value(left, 'f32'))}[{', '.join([':'] * (len(axes) + 1))}, {tail}]"
    right = aligned_row(as_dtype(row, "f32"), axes)
    return Value(f"jnp.sum({left} * {right}, axis={len(axes)}, dtype=jnp.float32)", "f32", axes, row.levels - 1)


def to_words(value: Value, given: tuple[str, ...], wanted: tuple[str, ...]) -> Value:
    """Returns a word numbered in another set."""
    if given == wanted:
        return value
    numbers = [wanted.index(x) if x in wanted else 255 for x in given]
    if value.literal:
        return literal(numbers[int(value.text)], "u8")
    shift = numbers[-1] - (len(numbers) - 1)
    if numbers == [(shift + i) % 256 for i in range(len(numbers))]:
        if shift == 0:
            return value
        return replace(value, text=f"{wrapped(value)} {'+' if shift > 0 else '-'} {abs(shift)}")
    table = ", ".join(map(str, numbers))
    return replace(value, text=f"jnp.asarray([{table}], jnp.uint8)[{value.text}]")


def arithmetic(e: ir.Arithmetic, frame: Frame, w: Writer) -> Value:
    dtype = "i32" if e.type.kind == "int" else "f32"
    args = [as_dtype(lower(a, frame, w), dtype) for a in e.args]
    if e.fn == "neg":
        if args[0].literal:
            return literal(-float(args[0].text), dtype)
        return replace(args[0], text=f"-{wrapped(args[0])}")
    if e.fn in ("min", "max"):
        result = args[0]
        for other in args[1:]:
            axes = union(result.axes, other.axes)
            text = f"jnp.{e.fn}imum({aligned(result, axes)}, {aligned(other, axes)})"
            result = Value(text, dtype, axes)
        return result
    return binary(e.fn, args[0], args[1], dtype)


def test(e: ir.Compare | ir.Same | ir.InRange | ir.InWords | ir.InSet | ir.IsEmpty, frame: Frame, w: Writer) -> Value:
    """Returns a comparison."""
    match e:
        case ir.Compare():
            left, right = lower(e.left, frame, w), lower(e.right, frame, w)
            dtype = "f32" if "f32" in (left.dtype, right.dtype) else "i32"
            return binary(e.fn, as_dtype(left, dtype), as_dtype(right, dtype), "bool")
        case ir.Same():
            left, right = lower(e.left, frame, w), lower(e.right, frame, w)
            if e.left.type.kind == "word":
                left, right = _common_words(e, left, right)
                if left.literal and right.literal:
                    return literal(left.text == right.text, "bool")
            return binary("==", left, right, "bool")
        case ir.InRange():
            value, low, high = (lower(x, frame, w) for x in (e.value, e.low, e.high))
            dtype = "f32" if "f32" in (value.dtype, low.dtype, high.dtype) else "i32"
            value, low, high = (as_dtype(x, dtype) for x in (value, low, high))
            return both(binary(">=", value, low, "bool"), binary("<=", value, high, "bool")) or literal(True, "bool")
        case ir.InWords():
            value = lower(e.value, frame, w)
            tests = [binary("==", value, literal(e.value.type.words.index(x), "u8"), "bool") for x in e.words]
            return _any(tests)
        case ir.InSet():
            container, value = lower(e.container, frame, w), lower(e.value, frame, w)
            bit = binary(">>", as_dtype(container, "u32"), as_dtype(value, "u32"), "u32")
            return binary("!=", binary("&", bit, literal(1, "u32"), "u32"), literal(0, "u32"), "bool")
        case ir.IsEmpty():
            return binary("==", lower(e.container, frame, w), literal(0, "u32"), "bool")
        case _:
            assert_never(e)


def _common_words(e: ir.Same, left: Value, right: Value) -> tuple[Value, Value]:
    a, b = e.left.type.words, e.right.type.words
    if isinstance(e.right, ir.Word):
        return left, to_words(right, b, a)
    if isinstance(e.left, ir.Word):
        return to_words(left, a, b), right
    union_ = tuple(dict.fromkeys(a + b))
    return to_words(left, a, union_), to_words(right, b, union_)


def _any(tests: list[Value]) -> Value:
    result = tests[0]
    for t in tests[1:]:
        result = binary("|", result, t, "bool")
    return result


def whereabouts(e: ir.Chose | ir.Unoccupied | ir.StandsOn, frame: Frame, w: Writer) -> Value:
    """Returns what an agent chose, whether a cell is free, whether an agent stands on a kind."""
    match e:
        case ir.Chose():
            who = owner(e.agent, frame, w)
            assert isinstance(who, AgentVar)
            text = "actions" if who.axis is not None else f"actions[{who.index.text}]"
            axes = (who.axis,) if who.axis is not None else who.index.axes
            return binary("==", Value(text, "i32", axes), literal(e.action, "i32"), "bool")
        case ir.Unoccupied():
            cell = owner(e.cell, frame, w)
            assert isinstance(cell, CellVar)
            return invert(state_reads.occupied(cell, w))
        case ir.StandsOn():
            who = owner(e.agent, frame, w)
            assert isinstance(who, AgentVar)
            return state_reads.site_under(who, e.kinds, w)[1]
        case _:
            assert_never(e)


def logic(e: ir.Logic, frame: Frame, w: Writer) -> Value:
    parts = [lower(a, frame, w) for a in e.args]
    if e.fn == "or":
        if any(p.text == "True" for p in parts):
            return literal(True, "bool")
        parts = [p for p in parts if p.text != "False"] or [literal(False, "bool")]
        return _any(parts)
    return both(*parts) or literal(True, "bool")


def case(e: ir.Case, frame: Frame, w: Writer) -> Value:
    """Returns nested selections, the last arm for all that is left."""
    subject = lower(e.subject, frame, w)
    if not subject.literal:
        subject = w.keep("subject", subject)
    dtype = {"int": "i32", "real": "f32", "word": "u8", "condition": "bool"}[e.type.kind]
    values = []
    for arm in e.arms:
        value = lower(arm.value, frame, w)
        if e.type.kind == "word":
            value = to_words(value, arm.value.type.words, e.type.words)
        values.append(as_dtype(value, dtype))
    result = values[-1]
    for arm, value in reversed(list(zip(e.arms[:-1], values[:-1], strict=True))):
        result = select(_arm_test(e, arm, subject), value, result)
    return result


def _arm_test(e: ir.Case, arm: ir.Arm, subject: Value) -> Value:
    if e.subject.type.kind == "condition":
        return subject if arm.words == ("yes",) else invert(subject)
    if arm.words:
        words = e.subject.type.words
        return _any([binary("==", subject, literal(words.index(x), "u8"), "bool") for x in arm.words])
    if arm.low is not None and arm.low == arm.high:
        return binary("==", subject, literal(arm.low, "i32"), "bool")
    low = None if arm.low is None else binary(">=", subject, literal(arm.low, "i32"), "bool")
    high = None if arm.high is None else binary("<=", subject, literal(arm.high, "i32"), "bool")
    return both(low, high) or literal(True, "bool")


__all__ = ["iota", "lower", "owner", "real", "reduce", "to_words"]
