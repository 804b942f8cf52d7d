"""Lowers entries of rows and tables: places of keys, and rows along an axis.

agent.trust[b] with two axes is the stored table itself: nothing is looked up.

The array of a value has a dimension for each of its axes (what it differs along, such as each
agent), then one for each level (what its entries are numbered by).
"""

from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.compiler.ir.entity_types import Level
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

ABSENT = 255  # the number of a word in a set that does not have it


def entry(e: ir.At, scope: IterationScope, w: Writer) -> Value:
    """Returns one entry of a row or table: by a key, or the expected one by a mix."""
    row = w.value(e.row, scope)
    if e.key.type.kind == "mix":
        return _expected(row, w.value(e.key, scope), w)
    along = whole_axis(e.key, scope)
    if along is not None and along not in row.axes:
        return unrolled(row, along)
    key = row_key(e.key, e.row.type.indexed_by[0], scope, w)
    if key.literal or not row.axes:
        return replace(taken(row, key.node, row.levels - 1), axes=row.axes or key.axes)
    axes = axes_of(row, key)
    if e.type.kind == "agents" and row.levels == 2:
        sets = call("entry", numbers_first(row_aligned(row, axes)), aligned(key, axes))
        return Value(numbers_last(sets), row.dtype, axes, 1)
    if row.levels != 1:
        feature = "a table of several levels by words that differ from member to member"
        raise NotSupported(feature, e.origin, "write one of the words out with `case`")
    node = call("entry", row_aligned(row, axes), aligned(key, axes))
    return Value(node, row.dtype, axes)


def row_key(e: ir.Expr, level: Level, scope: IterationScope, w: Writer) -> Value:
    """Returns the place of an entry in its row.

    It is that of a word in the row's own set, a number's distance from the first, or an agent's
    number.
    """
    if isinstance(e, ir.Word) and level.kind != "word":
        return literal(level.place_of(e.value), "i32")
    key = w.value(e, scope)
    match level.kind:
        case "word":
            return to_words(key, e.type.words, level.names, w)
        case "number":
            return as_dtype(key, "i32") - level.first
        case "agent":
            return key


def whole_axis(key: ir.Expr, scope: IterationScope) -> Axis | None:
    """Returns the axis along which a key is each agent once, in order; None for other keys."""
    variable = scope.variables[key.name] if isinstance(key, ir.Member) else None
    return variable.axis if isinstance(variable, AgentVar) else None


def unrolled(row: Value, along: Axis) -> Value:
    """Returns a row as values along an axis, one for each entry: its first level becomes the axis."""
    axes = union(row.axes, (along,))
    place = axes.index(along)
    entry_dimension = len(row.axes)
    node = row.node
    if place != entry_dimension:
        node = call("jnp.moveaxis", node, entry_dimension, place)
    return replace(row, node=node, axes=axes, levels=row.levels - 1)


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
    if row.levels > 1:
        left = left[*[ALL] * (len(axes) + 1), *[NEW_AXIS] * (row.levels - 1)]
    products = left * row_aligned(as_dtype(row, "f32"), axes)
    place = len(axes)
    if w.exact:
        total: Expression = call("sum_in_order", products, place)
    else:
        total = reduction("sum", products, (place,), "f32")
    expected = Value(total, "f32", axes, row.levels - 1)
    return w.keep("expected" if row.levels == 1 else "expected_row", expected)


def to_words(
    value: Value,
    old: tuple[str, ...],
    new: tuple[str, ...],
    w: Writer,
    declared: ir.VarField | None = None,
) -> Value:
    """Returns a word of the set `old`, numbered as in the set `new`; ABSENT where that lacks it.

    Args:
      declared: the field that the word will be a value of; names the constant of a literal.
    """
    if old == new and not (value.literal and declared):
        return value
    if value.literal:
        word = old[int(value.number)]
        return w.module.word(word, new, declared) if word in new else literal(ABSENT, "u8")
    numbers = [new.index(word) if word in new else ABSENT for word in old]
    # Adding one number may do; uint8 wraps around, so that it may also lead to ABSENT.
    shift = numbers[-1] - (len(numbers) - 1)
    shifted = [(shift + i) % 256 for i in range(len(numbers))]
    if numbers[1:] == shifted[1:] and (numbers[0] == shifted[0] or len(numbers) > 4):
        moved = value - abs(shift) if shift < 0 else value + shift
        if numbers[0] == shifted[0]:
            return moved
        return select(value.eq(0), numbers[0], moved)
    return looked_up(as_array(numbers, "u8"), value, "u8")
