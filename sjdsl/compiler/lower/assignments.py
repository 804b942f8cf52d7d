"""Lowers `set` and `add`: by selection along an axis, by scatter at computed places, or by lot."""

from collections import Counter
from dataclasses import replace
from math import prod

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.names import attribute_name
from sjdsl.compiler.ir.queries import all_fields, written_field
from sjdsl.compiler.lower import state_reads
from sjdsl.compiler.lower.axes import (
    FALSE,
    TRUE,
    Axis,
    Value,
    aligned,
    as_dtype,
    indexed,
    iota,
    joined,
    literal,
    reduce,
    select,
    spread,
    taken,
    union,
)
from sjdsl.compiler.lower.draws import random_bits
from sjdsl.compiler.lower.entries import rolled, row_key, to_words, unrolled, whole_axis
from sjdsl.compiler.lower.expressions import declared_by, nobody, owner
from sjdsl.compiler.lower.scope import AgentVar, CellVar, IterationScope, NotSupported, Variable
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    ALL,
    DTYPES,
    NEW_AXIS,
    REST,
    Attribute,
    Broadcast,
    Call,
    Cast,
    DType,
    Expression,
    Literal,
    Name,
    Slice,
    Where,
    as_array,
    call,
    constant,
    reduction,
    scalar,
    shape_of,
    written,
    zeros,
)

MOST_NESTED = 100  # additions in one expression, through which Python goes recursively
MOST_TERMS = 2**19  # of an exact sum: `runtime/exact_reals.py`


class Target(Record):
    """One field that a statement writes.

    who: whose it is, None for the world's. keys: of its row. scope: the instances that write.
    """

    declared: ir.VarField
    who: Variable | None
    keys: tuple[ir.Expr, ...]
    read: ir.FieldRead
    scope: IterationScope

    @property
    def attribute(self) -> str:
        return attribute_name(self.declared)

    @property
    def own_axes(self) -> tuple[Axis, ...] | None:
        """The axis of those whose field it is, none for the world's.

        None if they are computed numbers.
        """
        if self.who is None:
            return ()
        return None if self.who.axis is None else (self.who.axis,)

    def key(self, w: Writer) -> Value | None:
        """Returns the place of the entry of a row that is written; None for all of it."""
        if not self.keys:
            return None
        return row_key(self.keys[0], self.read.type.by[0], self.scope.always(), w)

    @property
    def along(self) -> Axis | None:
        """The axis that runs along the row that is written, one entry for each place.

        None where entries are found one by one.
        """
        axis = whole_axis(self.keys[0], self.scope) if self.keys else None
        if axis is None or self.own_axes is None or axis in self.own_axes:
            return None
        return axis


def past_the_end(who: Variable, w: Writer) -> Value:
    """Returns the number after that of the last agent or cell: what is written there is dropped."""
    return Value(w.module.extent(who.sort), "i32")


def fields_of_several_lots(phase: ir.Phase) -> frozenset[tuple[str, str]]:
    """Returns the fields, by holder and name, that several statements of a phase set by lot."""
    counts: Counter[tuple[str, str]] = Counter()
    for node in ir.walk(phase):
        if isinstance(node, ir.Set) and node.lot is not None:
            read = written_field(node.target)
            counts[read.held_by.what, read.name] += 1
    return frozenset(field for field, count in counts.items() if count > 1)


def write_by_lot(stream: int, target: Target, value: Value, w: Writer) -> None:
    """Writes one field, or an entry of a row, where the mask holds and the lot falls on it.

    Of the instances with one target, the one with the greatest rank writes. An earlier statement
    by lot is overwritten where this one drew a greater rank.
    """
    scope = target.scope
    one = literal(1, "u32")
    bits = random_bits(stream, scope, w) >> one
    rank = select(scope.mask, bits + one, literal(0, "u32"))
    index = literal(0, "i32") if target.who is None else target.who.number
    key = target.key(w)
    axes = union(scope.axes, index.axes, rank.axes, value.axes, () if key is None else key.axes)
    zero = literal(0, "i32")
    at = _flat(select(scope.mask, index, zero), axes, "i32")
    entry: Expression | None = None
    if key is not None:
        entry = _flat(select(scope.mask, as_dtype(key, "i32"), zero), axes, "i32")
    ranks = _flat(rank, axes, "u32")
    place, extent = _lot_places(target, at, entry, w)
    if (target.read.held_by.what, target.read.name) in w.several_lots:
        place = w.bind("place", place)
        ranks = _outranking(target, place, w.bind("rank", ranks), extent, w)
    won = w.bind("won", call("drawn_by_lot", place, ranks, extent))
    current = w.current(target.attribute)
    if target.who is None and entry is None:
        drawn_first = reduction("argmax", won, (0,))
        drawn = _values(value, target, axes, w)[drawn_first]
        w.assign(target.attribute, Where(reduction("any", won), drawn, current))
        return
    keys: tuple[Expression, ...]
    if target.who is None:
        past = scalar(w.module.num_entries(target.read.type.by[0]), "i32")
        keys = (Where(won, place, past),)
    else:
        past = scalar(past_the_end(target.who, w).node, "i32")
        if entry is None:
            keys = (Where(won, place, past),)
        else:
            keys = (Where(won, at, past), entry)
    new = _values(value, target, axes, w, along_row=entry is None) if value.axes else value.node
    w.assign(target.attribute, written("set_at", current, keys, new))


def _lot_places(
    target: Target, at: Expression, entry: Expression | None, w: Writer
) -> tuple[Expression, Expression]:
    """Returns the number of each instance's target among all that it may have, and how many.

    Each entry of each row is one target.
    """
    extent: Expression = Literal(1)
    if target.who is not None:
        extent = w.module.extent(target.who.sort)
    if entry is None:
        return at, extent
    num_entries = w.module.num_entries(target.read.type.by[0])
    if target.who is None:
        return entry, num_entries
    place = at * num_entries + entry
    return place, extent * num_entries


def _outranking(
    target: Target,
    place: Expression,
    ranks: Name,
    extent: Expression,
    w: Writer,
) -> Name:
    """Returns the ranks above those that earlier statements drew for a target, others as 0."""
    best: Expression | None = w.best_ranks.get(target.attribute)
    if best is not None:
        ranks = w.bind("rank", call("outranking", place, ranks, best))
    best = best or zeros("u32", extent)
    kept = w.bind("best", call("best_ranks", place, ranks, best))
    w.best_ranks[target.attribute] = kept
    return ranks


def _values(
    value: Value, target: Target, axes: tuple[Axis, ...], w: Writer, along_row: bool = False
) -> Expression:
    """Returns the value of each instance, in the order of their numbers.

    along_row: whether one value that a whole row is set to gets a new axis.
    """
    type_ = target.read.type
    if target.keys:
        type_ = type_.model_copy(update={"by": ()})
    entries = [w.module.num_entries(level) for level in type_.by]
    set_extents = [Literal(w.module.numbers_per_set)] * (w.module.levels(type_) - len(entries))
    if value.levels > len(set_extents):
        return _flat(value, axes, value.dtype, (*entries, *set_extents))
    flat = _flat(value, axes, value.dtype, tuple(set_extents))
    if along_row and entries and value.levels == len(set_extents):
        return flat[:, None]
    return flat


def _flat(
    value: Value,
    axes: tuple[Axis, ...],
    dtype: DType,
    inside: tuple[Expression, ...] = (),
) -> Expression:
    """Returns a value for each instance, in the order of their numbers.

    inside: extents of the value's own levels.
    """
    node = aligned(value, axes, value.levels)
    if value.literal:
        node = as_array(node, dtype)
    full = Broadcast(node, (*(a.extent for a in axes), *inside))
    return Call(Attribute(full, "reshape"), (Literal(-1), *inside))


def set_(s: ir.Set, scope: IterationScope, w: Writer) -> None:
    """Writes `set target = value`."""
    with w.deciding(w.module.deciding.has_field(written_field(s.target))):
        value = stored_value(s.value, s.target, scope, w)
    reached = targets(s.target, scope, w)
    if len(reached) > 1 and not value.literal:
        value = w.keep("written", value)
    for target in reached:
        kept = as_dtype(value, state_reads.storage(target.declared, w))
        if s.lot is not None:
            write_by_lot(s.lot, target, kept, w)
        else:
            _write(target, kept, w)


def stored_value(e: ir.Expr, target: ir.Expr, scope: IterationScope, w: Writer) -> Value:
    """Returns a value as a field stores it.

    Words are numbered in its own set, agents are numbers, and nobody may be the empty set.
    """
    if isinstance(e, ir.Nobody):
        return literal(0, w.module.set_dtype) if target.type.kind == "agents" else nobody(w)
    if isinstance(e, ir.Case) and e.type.kind == "word":  # its arms at once in the field's words
        e = e.model_copy(update={"type": target.type})
    if target.type.kind == "cell":
        return state_reads.kept_cell(e, scope, w)
    value = w.value(e, scope)
    match target.type.kind:
        case "word":
            return to_words(value, e.type.words, target.type.words, w, declared_by(target, w))
        case "real":
            return as_dtype(value, "f32")
        case _:
            return value


def targets(target: ir.Expr, scope: IterationScope, w: Writer) -> list[Target]:
    """Returns the fields a write reaches: one, or one for each kind of a group on the map."""
    keys: tuple[ir.Expr, ...] = ()
    while isinstance(target, ir.At):
        keys = (target.key, *keys)
        target = target.row
    assert isinstance(target, ir.FieldRead)
    read = target
    who = None if read.owner is None else owner(read.owner, scope, w)
    if not isinstance(who, CellVar) or len(who.kinds) == 1:
        return [Target(w.module.field(read), who, keys, read, scope)]
    layout = w.module.layout
    on_map = [kind for kind in who.kinds if layout.num_cells((kind,))]
    if len(on_map) > 1:  # the mask once for all kinds
        scope = replace(scope, mask=w.keep("active", scope.mask))
    of_kinds = []
    for kind in on_map:
        table = layout.numbers_table(who.kinds, kind)
        comment = f"number among {kind} of each cell of the group; past the end: none"
        name = w.module.constant(f"{'_'.join(who.kinds)}_to_{kind}", table, comment)
        key = who.site.node if who.axis is None else Slice(None, Literal(-1))
        cell = CellVar(Value(name[key], "i32", who.site.axes), (kind,))
        of_kinds.append(Target(w.module.field(read, kind), cell, keys, read, scope))
    return of_kinds


def _write(target: Target, value: Value, w: Writer) -> None:
    """Writes one field where the scope's mask holds."""
    own, along = target.own_axes, target.along
    key = target.key(w) if along is None else None
    if own is None or (key is not None and any(a.size > 1 and a not in own for a in key.axes)):
        _scatter(target, key, value, w)
        return
    stored = Value(
        w.current(target.attribute),
        state_reads.storage(target.declared, w),
        own,
        w.module.levels(target.read.type),
    )
    before = stored if along is None else unrolled(stored, along)
    own = before.axes
    over = tuple(a for a in target.scope.axes if a not in own)
    mask = reduce("any", target.scope.mask, over)
    if mask == FALSE:
        return
    key = None if key is None else _of_the_one(key, over, target.scope.mask)
    after = _entries(before, mask, key, target, _of_the_one(value, over, target.scope.mask), w)
    if after != before:
        w.assign(target.attribute, after.node if along is None else rolled(after.node, own, along))


def _of_the_one(value: Value, over: tuple[Axis, ...], mask: Value) -> Value:
    """Returns a value or key without axes of the scope that the target lacks.

    It is that of the one instance that writes. The value differs along them only if one instance
    at most reaches each target (else the write is refused): they are lanes of shapes with one
    lane, or `mask` holds for one instance at most.
    """
    gone = tuple(a for a in over if a in value.axes)
    if not gone:
        return value
    if any(a.size > 1 for a in gone):  # the sum is the value of the one instance that happens
        assert mask != TRUE, over
        number: DType = value.dtype if value.dtype in ("f32", "u32") else "i32"
        masked = select(mask, as_dtype(value, number), literal(0, number))
        return as_dtype(reduce("sum", masked, over), value.dtype)
    keys = tuple(Literal(0) if a in gone else ALL for a in value.axes)
    kept = tuple(a for a in value.axes if a not in gone)
    return replace(value, node=value.node[keys], axes=kept)


def _entries(
    before: Value, mask: Value, key: Value | None, target: Target, value: Value, w: Writer
) -> Value:
    """Returns the field with the value in its place: the whole, or one entry of a row."""
    if key is None and mask != TRUE:
        return select(mask, value, before)
    if (
        key is None
        and value.axes == before.axes
        and value.levels == before.levels
        and not value.literal
    ):
        return value
    if key is None and not value.axes and not value.levels:
        return replace(before, node=call("jnp.full_like", before.node, value.node))
    if key is None:
        rows = aligned(value, before.axes, before.levels)
        return replace(before, node=call("jnp.broadcast_to", rows, Attribute(before.node, "shape")))
    if key.literal:
        new = select(mask, value, taken(before, key.node, before.levels - 1))
        of_words = {"axis": constant(-2)} if before.levels > 1 else {}
        return replace(before, node=call("set_entry", before.node, key.node, new.node, **of_words))
    hit = _entries_of_word(key, before.axes, target, w)
    if mask != TRUE:
        hit = hit & _for_each_word(mask, before.axes)
    if before.levels > 1:  # of large sets
        words = hit[..., None]
        return replace(
            before, node=Where(words, aligned(value, before.axes, before.levels), before.node)
        )
    return replace(before, node=Where(hit, _for_each_word(value, before.axes), before.node))


def _entries_of_word(key: Value, axes: tuple[Axis, ...], target: Target, w: Writer) -> Expression:
    """Returns which entries of the rows are those of a word that is computed."""
    words = w.module.num_entries(target.read.type.by[0])
    hit = call("one_hot", aligned(key, axes), words)
    if axes and not key.axes:
        return hit[*[NEW_AXIS] * len(axes), :]
    return hit


def _for_each_word(value: Value, axes: tuple[Axis, ...]) -> Expression:
    """Returns a value with one more axis, for the entries of a row; a scalar stays one."""
    return indexed(aligned(value, axes), (REST, NEW_AXIS)) if value.axes else value.node


def _scatter(target: Target, key: Value | None, value: Value, w: Writer) -> None:
    """Writes at computed places; instances that do not happen write past the end."""
    scope = target.scope
    if target.who is None:
        assert key is not None
        index = as_dtype(key, "i32")
        name = "to_entry"
        past = Value(w.module.num_entries(target.read.type.by[0]), "i32")
        entry = None
    else:
        index = target.who.number
        name = _place(target.who)
        past = past_the_end(target.who, w)
        entry = key
    axes = union(index.axes, scope.mask.axes, value.axes, () if entry is None else entry.axes)
    at = w.keep(name, Value(spread(select(scope.mask, index, past), axes), "i32", axes))
    keys: tuple[Expression, ...] = (at.node,)
    if entry is not None:
        keys = (at.node, aligned(entry, axes))
    levels = w.module.levels(target.read.type) - (key is not None)
    new = aligned(value, axes, levels) if value.axes else value.node
    current = w.current(target.attribute)
    w.assign(target.attribute, written("set_at", current, keys, new))


def _place(who: Variable) -> str:
    """Returns the name of the numbers of those who are written to."""
    return "to_agent" if isinstance(who, AgentVar) else f"to_{'_'.join(who.kinds)}"


def add(s: ir.Add, scope: IterationScope, w: Writer) -> None:
    """Collects `add value to target`; the sums are applied at the end of the phase."""
    decides = w.module.deciding.has_field(written_field(s.target))
    for target in targets(s.target, scope, w):
        if target.read.type.kind == "agents":
            _add_member(s, target, w)
            continue
        dtype: DType = "f32" if target.read.type.kind == "real" else "i32"
        with w.deciding(decides):
            value = as_dtype(w.value(s.value, scope), dtype)
        is_exact = decides and value.dtype == "f32"
        if is_exact:
            _count_terms(target, s, w)
        _add_number(target, value, is_exact, w)


def _count_terms(target: Target, s: ir.Add, w: Writer) -> None:
    """Counts the terms of an exact sum, and refuses too many."""
    separate = target.own_axes or ()  # each member of these has a sum of its own
    summed = prod(axis.size for axis in target.scope.axes if axis not in separate)
    terms = w.terms.get(target.attribute, 0) + summed
    if terms >= MOST_TERMS:
        feature = (
            f"{MOST_TERMS:,} or more additions in a phase to a real field that decides something"
        )
        raise NotSupported(feature, s.origin, "add up in several phases, or count in whole numbers")
    w.terms[target.attribute] = terms


def _add_number(target: Target, value: Value, is_exact: bool, w: Writer) -> None:
    """Collects the sums of a number over the instances.

    is_exact: whether they are of reals as fixed-point numbers, whose digits are one more level.
    """
    scope = target.scope
    if scope.mask == TRUE or not value.levels:
        masked = select(scope.mask, value, 0)
    else:
        axes = union(scope.mask.axes, value.axes)
        test = aligned(scope.mask, axes, value.levels) if scope.mask.axes else scope.mask.node
        masked = replace(value, node=Where(test, aligned(value, axes), Literal(0)), axes=axes)
    sums = w.added.setdefault(target.attribute, [])
    own = target.own_axes
    key = target.key(w) if own is None or target.along is None else None
    if key is not None:
        axes = union(
            masked.axes, key.axes
        )  # a row that has the value at the key's word and 0 elsewhere
        zero = scalar(literal(0, masked.dtype).node, masked.dtype)
        row = Where(_entries_of_word(key, axes, target, w), _for_each_word(masked, axes), zero)
        masked = Value(row, masked.dtype, axes, 1)
    if is_exact:
        given = scalar(masked.node, "f32") if masked.literal else masked.node
        masked = Value(call("fixed_point", given), "i32", masked.axes, masked.levels + 1)
    if own is not None and target.along is not None:
        entries = union(own, (target.along,))
        total = reduce("sum", masked, tuple(a for a in scope.axes if a not in entries))
        is_array = bool(total.axes or total.levels)
        node = rolled(aligned(total, entries), entries, target.along) if is_array else total.node
        sums.append(
            w.keep(
                f"{target.attribute}_added",
                Value(node, total.dtype, own if is_array else (), is_array + is_exact),
            )
        )
        return
    if own is not None:
        total = reduce("sum", masked, tuple(a for a in scope.axes if a not in own))
        if (
            total.axes or total.levels
        ):  # a row that is the same for all is aligned too: JAX would not know which axis it lacks
            total = replace(total, node=aligned(total, own), axes=own)
        sums.append(w.keep(f"{target.attribute}_added", total))
        return
    assert target.who is not None
    index = target.who.number
    axes = union(index.axes, masked.axes)
    total = reduce("sum", masked, tuple(a for a in scope.axes if a not in axes))
    extent = w.module.extent(target.who.sort)
    dtype = "f32" if is_exact else total.dtype
    zeros = call(
        "jnp.zeros",
        shape_of((extent, *map(w.module.num_entries, target.read.type.by))),
        DTYPES[dtype],
    )
    if is_exact:
        zeros = call("fixed_point", zeros)
    amount = aligned(total, axes) if total.axes or total.levels else total.node
    shape = (Axis(f"all of {target.attribute}", extent.size, 0),)
    places = (spread(index, axes) if axes else index.node,)
    sets = written("add_at", zeros, places, amount)
    sums.append(
        w.keep(
            f"{target.attribute}_added",
            Value(sets, total.dtype, shape, len(target.read.type.by) + is_exact),
        )
    )


def _add_member(s: ir.Add, target: Target, w: Writer) -> None:
    """Adds agents to sets kept as bits: a table of who is added where, folded into bits."""
    scope, who = target.scope, target.who
    member = w.value(s.value, scope)
    joining = scope.variables[s.value.name] if isinstance(s.value, ir.Member) else None
    dtype, words = w.module.set_dtype, w.module.numbers_per_set
    keys = [x for x in (target.key(w),) if x is not None]
    around = union(member.axes, *(k.axes for k in keys), scope.mask.axes)
    sizes = [w.module.num_entries(target.read.type.by[0]) for _ in keys]
    sets: Expression
    if who is None:  # those who are not added are numbers past the end
        axes = around
        at = w.keep(
            "member",
            Value(
                spread(select(scope.mask, member, Value(w.module.agents, "i32")), axes), "i32", axes
            ),
        )
        sets = _folded([aligned(key, axes) for key in keys], at.node, sizes, w)
    else:
        axes = union(who.number.axes, around)
        at = Value(spread(select(scope.mask, who.number, past_the_end(who, w)), axes), "i32", axes)
        places = [w.keep(_place(who), at).node, *(aligned(key, axes) for key in keys)]
        extents = [w.module.extent(who.sort), *sizes]
        itself = joining.axis if isinstance(joining, AgentVar) else None
        once = (
            itself is not None and itself in axes and all(a.size == 1 or a == itself for a in axes)
        )  # each agent joins once at most
        if once and not words:
            assert itself is not None
            bits = Value(
                scalar(Literal(1), dtype) << iota(itself, dtype).node,
                dtype,
                (itself,),
            )
            none = zeros(dtype, *extents)
            sets = written("add_at", none, tuple(places), aligned(bits, axes))
        else:
            sets = _folded(places, aligned(member, axes), extents, w)
    if target.read.type.by and not keys:  # to every entry of the row
        sets = sets[*[ALL] * (who is not None), None]
    joined_sets = w.keep(f"{target.attribute}_joined", Value(sets, dtype))
    w.joined.setdefault(target.attribute, []).append(joined_sets.node)


def _folded(
    places: list[Expression], member: Expression, sizes: list[Literal], w: Writer
) -> Expression:
    """Returns the sets to which instances add an agent each, as bits.

    places: where each instance adds; sizes: how many places there are.
    """
    empty = zeros("bool", *sizes, w.module.agents)
    table = written("set_at", empty, (*places, member), Literal(True))
    members = w.keep("members", Value(table, "bool")).node
    if w.module.numbers_per_set:
        return call("pack", members)
    return call("as_bits", members, DTYPES[w.module.set_dtype])


def finish(w: Writer) -> None:
    """Applies the sums of the phase, brings capped fields into their range, and joins sets."""
    for attribute, sums in w.added.items():
        declared = next(f for f in all_fields(w.module.game) if attribute_name(f) == attribute)
        stored_dtype = state_reads.storage(declared, w)
        dtype: DType = "i32" if declared.type.kind == "int" else "f32"
        node = as_dtype(Value(w.current(attribute), stored_dtype), dtype).node
        is_exact = attribute in w.terms
        if is_exact:
            node = call("fixed_point", node)
        for number, total in enumerate(sums, 1):
            node = joined("+", node, total.node)
            if number % MOST_NESTED == 0:
                node = w.bind(attribute, node)
        if is_exact:
            node = call("rounded", node)
        if declared.capped:
            low = Literal(int(declared.type.low))
            high = Literal(int(declared.type.high))
            node = call("jnp.clip", node, low, high)
        if stored_dtype not in ("i32", "f32"):
            node = Cast(node, stored_dtype)
        w.assign(attribute, node)
    for attribute, sets in w.joined.items():
        node = w.current(attribute)
        for number, members in enumerate(sets, 1):
            node = node | members
            if number % MOST_NESTED == 0:
                node = w.bind(attribute, node)
        w.assign(attribute, node)
