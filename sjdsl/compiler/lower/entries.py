"""Lowers entries of rows and tables, such as `a.trust[b]`.

The array of a value has a dimension for each of its axes (what it differs along, such as each
agent), then one for each index set of the row (agents, words or numbers). If a and b are both each
agent once, in order, `a.trust[b]` is the stored table itself: its dimension becomes the axis of b.
"""

from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.compiler.ir.entity_types import IndexSet
from sjdsl.compiler.lower.axes import (
    Axes,
    Axis,
    Value,
    aligned,
    as_dtype,
    axes_of,
    literal,
    looked_up,
    row_aligned,
    select,
    taken,
    union,
)
from sjdsl.compiler.lower.scope import AgentVar, IterationScope, NotSupported
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    ALL,
    NEW_AXIS,
    Expression,
    as_array,
    call,
    reduction,
)

ABSENT = 255  # in place of the number of an enum value in an enum without it


def entry(e: ir.At, scope: IterationScope, w: Writer) -> Value:
    """Returns the entry `row[key]` of a row or table; if the key is a mix, a mean of entries."""
    row = w.value(e.row, scope)
    if e.key.type.kind == "mix":
        return _expected(row, w.value(e.key, scope), w)
    along = whole_axis(e.key, scope)
    if along is not None and along not in row.axes:
        return unrolled(row, along)
    key = row_key(e.key, e.row.type.indexed_by[0], scope, w)
    if key.literal or not row.axes:
        return replace(taken(row, key.node, row.row_dims - 1), axes=row.axes or key.axes)
    axes = axes_of(row, key)
    entries = row_aligned(row, axes)
    keys = aligned(key, axes)
    if row.row_dims == 1:
        return Value(call("entry", entries, keys), row.dtype, axes)
    if e.type.kind == "agents" and row.row_dims == 2:  # large sets
        sets = call("entry", numbers_first(entries), keys)
        return Value(numbers_last(sets), row.dtype, axes, 1)
    feature = "a table of several levels by words that differ from member to member"
    raise NotSupported(feature, e.origin, "write one of the words out with `case`")


def row_key(e: ir.Expr, index_set: IndexSet, scope: IterationScope, w: Writer) -> Value:
    """Returns the place of a key's entry in a row, from 0.

    index_set: of the row: words, whole numbers from `first` on, or agents.
    """
    if isinstance(e, ir.Word) and index_set.kind != "word":
        return literal(index_set.place_of(e.value), "i32")
    key = w.value(e, scope)
    match index_set.kind:
        case "word":
            return to_words(key, e.type.words, index_set.names, w)
        case "number":
            return as_dtype(key, "i32") - index_set.first
        case "agent":
            return key


def whole_axis(key: ir.Expr, scope: IterationScope) -> Axis | None:
    """Returns the axis along which a key is each agent once, in order; None for any other key."""
    variable = scope.variables[key.name] if isinstance(key, ir.Member) else None
    return variable.axis if isinstance(variable, AgentVar) else None


def unrolled(row: Value, along: Axis) -> Value:
    """Returns a row as values along an axis, one for each entry: its first dimension."""
    axes = union(row.axes, (along,))
    place = axes.index(along)
    entry_dimension = len(row.axes)
    node = row.node
    if place != entry_dimension:
        node = call("jnp.moveaxis", node, entry_dimension, place)
    return replace(row, node=node, axes=axes, row_dims=row.row_dims - 1)


def rolled(node: Expression, axes: Axes, along: Axis) -> Expression:
    """Returns an array over axes with one of them last: the inverse of `unrolled`."""
    place = axes.index(along)
    last = len(axes) - 1
    if place == last:
        return node
    return call("jnp.moveaxis", node, place, last)


def numbers_first(sets: Expression) -> Expression:
    """Returns large sets with the axis of their numbers first, so that entries come last."""
    return call("jnp.moveaxis", sets, -1, 0)


def numbers_last(sets: Expression) -> Expression:
    """Returns large sets as they are stored: the inverse of `numbers_first`."""
    return call("jnp.moveaxis", sets, 0, -1)


def _expected(row: Value, shares: Value, w: Writer) -> Value:
    """Returns the mean of a row's entries, weighed by shares."""
    axes = axes_of(row, shares)
    left = row_aligned(shares, axes)
    if row.row_dims > 1:
        left = left[*[ALL] * (len(axes) + 1), *[NEW_AXIS] * (row.row_dims - 1)]
    products = left * row_aligned(as_dtype(row, "f32"), axes)
    place = len(axes)
    if w.exact:
        total: Expression = call("sum_in_order", products, place)
    else:
        total = reduction("sum", products, (place,), "f32")
    expected = Value(total, "f32", axes, row.row_dims - 1)
    return w.keep("expected" if row.row_dims == 1 else "expected_row", expected)


def to_words(
    value: Value,
    old: tuple[str, ...],
    new: tuple[str, ...],
    w: Writer,
    declared: ir.VarField | None = None,
) -> Value:
    """Returns a value of the enum `old`, numbered as in the enum `new`; ABSENT where that lacks it.

    Args:
      declared: the field that the value will be stored in; names the constant of a literal.
    """
    if old == new and not (value.literal and declared):
        return value
    if value.literal:
        word = old[int(value.number)]
        return w.module.word(word, new, declared) if word in new else literal(ABSENT, "u8")
    new_numbers = [new.index(word) if word in new else ABSENT for word in old]
    # Often the new number is the old one plus a constant, modulo 256, at least from 1 on.
    shift = new_numbers[-1] - (len(old) - 1)
    shifted = [(number + shift) % 256 for number in range(len(old))]
    is_shift = new_numbers == shifted
    if is_shift or (new_numbers[1:] == shifted[1:] and len(old) > 4):
        moved = value - abs(shift) if shift < 0 else value + shift
        return moved if is_shift else select(value.eq(0), new_numbers[0], moved)
    return looked_up(as_array(new_numbers, "u8"), value, "u8")
