"""Lowers `set … by lot`: of all instances that would write one target, over all such statements of a phase, one drawn does."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import written_field
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import Axis, Value, aligned, as_dtype, binary, literal, select, union
from sjdsl.compiler.lower.draws import random_bits
from sjdsl.compiler.lower.targets import Target, past_the_end
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program import expressions as array


def fields_of_several_lots(phase: ir.Phase) -> frozenset[tuple[str, str]]:
    """Returns the fields, by holder and name, that several statements of a phase set by lot."""
    sets = [written_field(s.target) for s in ir.walk(phase) if isinstance(s, ir.Set) and s.lot is not None]
    named = [(read.held_by.what, read.name) for read in sets]
    return frozenset(field for field in named if named.count(field) > 1)


def write_by_lot(stream: int, target: Target, value: Value, w: Writer) -> None:
    """Writes one field, or an entry of a row, where the scope's mask holds and the lot falls on the instance: one for each target.

    What an earlier statement wrote by lot is overwritten where this one drew a greater rank.
    """
    scope = target.scope
    word = binary(">>", random_bits(stream, scope, w), literal(1, "u32"), "u32")
    rank = select(scope.mask, binary("+", word, literal(1, "u32"), "u32"), literal(0, "u32"))
    index = literal(0, "i32") if target.who is None else target.who.number
    key = target.key(w)
    axes = union(scope.axes, index.axes, rank.axes, value.axes, () if key is None else key.axes)
    at = _flat(select(scope.mask, index, literal(0, "i32")), axes, "i32")
    entry = None if key is None else _flat(select(scope.mask, as_dtype(key, "i32"), literal(0, "i32")), axes, "i32")
    place, extent = _place(target, at, entry, w)
    place, ranks = _ranked(target, place, _flat(rank, axes, "u32"), extent, w)
    won = w.bind("won", array.call("drawn_by_lot", place, ranks, extent))
    if target.who is None and entry is None:
        here = array.call("jnp.argmax", won)
        drawn = array.Index(_values(value, target, axes, w), (here,))
        w.assign(target.attribute, array.Where(array.Reduce("any", won, None, None), drawn, w.current(target.attribute)))
        return
    past = w.module.num_entries(target.read.type.by[0]) if target.who is None else past_the_end(target.who, w).node
    mine = place if target.who is None or entry is None else at
    keys = (array.Where(won, mine, array.scalar(past, "i32")), *([entry] if target.who is not None and entry is not None else []))
    new = _values(value, target, axes, w, along_row=entry is None) if value.axes else value.node
    w.assign(target.attribute, array.Update(w.current(target.attribute), keys, "set", new, drop=True))


def _place(target: Target, at: array.Expression, entry: array.Expression | None, w: Writer) -> tuple[array.Expression, array.Expression]:
    """Returns the number of each instance's target, and how many targets there are."""
    extent: array.Expression = array.Literal(1) if target.who is None else state_reads.total_extent(target.who, w)
    if entry is None:
        return at, extent
    words = w.module.num_entries(target.read.type.by[0])
    if target.who is None:
        return entry, words
    return array.Binary("+", array.Binary("*", at, words), entry), array.Binary("*", extent, words)


def _ranked(
    target: Target, place: array.Expression, rank: array.Expression, extent: array.Expression, w: Writer
) -> tuple[array.Expression, array.Expression]:
    """Returns the targets and ranks; of a field that several statements set by lot, only ranks above those drawn by the earlier ones."""
    if (target.read.held_by.what, target.read.name) not in w.several_lots:
        return place, rank
    place, rank = w.bind("place", place), w.bind("rank", rank)
    earlier = w.best_ranks.get(target.attribute)
    if earlier is not None:
        rank = w.bind("rank", array.call("outranking", place, rank, earlier))
    best = array.call("jnp.zeros", extent, array.DTYPES["u32"]) if earlier is None else earlier
    w.best_ranks[target.attribute] = w.bind("best", array.call("best_ranks", place, rank, best))
    return place, rank


def _values(value: Value, target: Target, axes: tuple[Axis, ...], w: Writer, along_row: bool = False) -> array.Expression:
    """Returns the value of each instance; one value that a whole row is set to stands beside a new axis."""
    type_ = target.read.type if not target.keys else target.read.type.model_copy(update={"by": ()})
    words = [w.module.num_entries(level) for level in type_.by]
    large = [array.Literal(w.module.set_words)] * (w.module.levels(type_) - len(words))
    flat = _flat(value, axes, value.dtype, tuple([*words, *large] if value.levels > len(large) else large))
    return array.Index(flat, (array.ALL, array.NEW_AXIS)) if along_row and words and value.levels == len(large) else flat


def _flat(value: Value, axes: tuple[Axis, ...], dtype: array.DType, inside: tuple[array.Expression, ...] = ()) -> array.Expression:
    """Returns a value for each instance, in the order of their numbers. `inside`: extents of the value's own axes."""
    extents = (*(a.extent for a in axes), *inside)
    full = array.Broadcast(array.as_array(aligned(value, axes), dtype) if value.literal else aligned(value, axes, value.levels), extents)
    return array.Call(array.Attribute(full, "reshape"), (array.Literal(-1), *inside))
