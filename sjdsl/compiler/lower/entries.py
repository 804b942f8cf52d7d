"""Lowers entries of rows and tables: the place that a key stands for, and rows whose entries an axis runs along.

agent.trust[b] of two axes is the stored table itself, one side of it being the row: nothing is looked up.
"""

from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.compiler.ir.sorts import Level
from sjdsl.compiler.lower.axes import (
    Axis,
    Value,
    aligned,
    as_dtype,
    binary,
    literal,
    select,
    taken,
    union,
)
from sjdsl.compiler.lower.scope import AgentVar, IterationScope, NotSupported
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program import expressions as array

ABSENT = 255  # the number of a word in a set that does not have it


def entry(e: ir.At, scope: IterationScope, w: Writer) -> Value:
    """Returns one entry of a row or table: by a key, or the expected one by a mix."""
    row = w.value(e.row, scope)
    if e.key.type.kind == "mix":
        return _expected(row, w.value(e.key, scope), w)
    along = whole_axis(e.key, scope)
    if along is not None and along not in row.axes:
        return unrolled(row, along)
    key = row_key(e.key, e.row.type.by[0], scope, w)
    if key.literal or not row.axes:
        return replace(taken(row, key.node, row.levels - 1), axes=row.axes or key.axes)
    axes = union(row.axes, key.axes)
    if e.type.kind == "agents" and row.levels == 2:
        found = array.call("entry", words_first(aligned_row(row, axes)), aligned(key, axes))
        return Value(words_last(found), row.dtype, axes, 1)
    if row.levels != 1:
        instead = "write one of the words out with `case`"
        raise NotSupported(
            "a table of several levels by words that differ from member to member",
            e.origin,
            instead,
        )
    return Value(array.call("entry", aligned_row(row, axes), aligned(key, axes)), row.dtype, axes)


def row_key(e: ir.Expr, level: Level, scope: IterationScope, w: Writer) -> Value:
    """Returns the place of an entry in its row: of a word in the row's own set, of a number from the first one, of an agent its number."""
    if isinstance(e, ir.Word) and level.sort != "word":
        return literal(level.place_of(e.value), "i32")
    key = w.value(e, scope)
    match level.sort:
        case "word":
            return to_words(key, e.type.words, level.names, w)
        case "number":
            return binary("-", as_dtype(key, "i32"), literal(level.first, "i32"), "i32")
        case "agent":
            return key


def whole_axis(key: ir.Expr, scope: IterationScope) -> Axis | None:
    """Returns the axis along which a key is each agent once, in the order of their numbers; None for all other keys."""
    who = scope.variables[key.name] if isinstance(key, ir.Member) else None
    return who.axis if isinstance(who, AgentVar) else None


def unrolled(row: Value, along: Axis) -> Value:
    """Returns a row as what it holds along an axis, one entry for each place."""
    axes = union(row.axes, (along,))
    place, first = axes.index(along), len(row.axes)
    node = (
        row.node
        if place == first
        else array.call("jnp.moveaxis", row.node, array.Literal(first), array.Literal(place))
    )
    return replace(row, node=node, axes=axes, levels=row.levels - 1)


def rolled(node: array.Expression, axes: tuple[Axis, ...], along: Axis) -> array.Expression:
    """Returns an array over axes with one of them last: what `unrolled` was given."""
    place, last = axes.index(along), len(axes) - 1
    return (
        node
        if place == last
        else array.call("jnp.moveaxis", node, array.Literal(place), array.Literal(last))
    )


def aligned_row(row: Value, axes: tuple[Axis, ...]) -> array.Expression:
    """Returns a row lined up with axes, its levels last."""
    if row.axes == axes:
        return row.node
    return array.Index(
        row.node, tuple(array.ALL if a in row.axes else array.NEW_AXIS for a in axes)
    )


def words_first(sets: array.Expression) -> array.Expression:
    """Returns large sets with the axis of their words first, so that the entries of rows stand last as those of other rows do."""
    return array.call("jnp.moveaxis", sets, array.Literal(-1), array.Literal(0))


def words_last(sets: array.Expression) -> array.Expression:
    """Returns what was made of `words_first` as sets are kept."""
    return array.call("jnp.moveaxis", sets, array.Literal(0), array.Literal(-1))


def _expected(row: Value, shares: Value, w: Writer) -> Value:
    axes = union(row.axes, shares.axes)
    left = aligned_row(shares, axes)
    if row.levels > 1:
        left = array.Index(
            left, (*[array.ALL] * (len(axes) + 1), *[array.NEW_AXIS] * (row.levels - 1))
        )
    products = array.Binary("*", left, aligned_row(as_dtype(row, "f32"), axes))
    place = len(axes)
    if w.exact:
        total: array.Expression = array.call("sum_in_order", products, array.Literal(place))
    else:
        total = array.reduction("sum", products, (place,), "f32")
    expected = Value(total, "f32", axes, row.levels - 1)
    return w.keep("expected" if row.levels == 1 else "expected_row", expected)


def to_words(
    value: Value,
    given: tuple[str, ...],
    wanted: tuple[str, ...],
    w: Writer,
    declared: ir.VarField | None = None,
) -> Value:
    """Returns a word of the set `given`, renumbered for the set `wanted`; ABSENT where that lacks it.

    Args:
      declared: the field that the word will be a value of; names the constant of a literal.
    """
    if given == wanted and not (value.literal and declared):
        return value
    if value.literal:
        word = given[int(value.number)]
        return w.module.word(word, wanted, declared) if word in wanted else literal(ABSENT, "u8")
    numbers = [wanted.index(x) if x in wanted else ABSENT for x in given]
    shift = numbers[-1] - (
        len(numbers) - 1
    )  # uint8 wraps around, so a shift may also lead to ABSENT
    if numbers == [(shift + i) % 256 for i in range(len(numbers))]:
        return binary("-" if shift < 0 else "+", value, literal(abs(shift), "u8"), "u8")
    if len(numbers) > 4 and numbers[1:] == [
        (shift + i) % 256 for i in range(1, len(numbers))
    ]:  # all but the first
        others = binary("-" if shift < 0 else "+", value, literal(abs(shift), "u8"), "u8")
        return select(
            binary("==", value, literal(0, "u8"), "bool"), literal(numbers[0], "u8"), others
        )
    return replace(
        value, node=array.Index(array.as_array(array.constant([*numbers]), "u8"), (value.node,))
    )
