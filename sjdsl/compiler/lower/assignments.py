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
    Axes,
    Axis,
    Value,
    aligned,
    as_dtype,
    axes_of,
    broadcast,
    iota,
    joined,
    literal,
    one_hot,
    reduce,
    select,
    spread,
    taken,
    union,
    without,
)
from sjdsl.compiler.lower.draws import random_bits
from sjdsl.compiler.lower.entries import rolled, row_key, to_words, unrolled, whole_axis
from sjdsl.compiler.lower.expressions import declared_by, nobody, owner
from sjdsl.compiler.lower.scope import AgentVar, CellVar, IterationScope, NotSupported, Variable
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    ALL,
    DTYPES,
    Attribute,
    Broadcast,
    Cast,
    DType,
    Expression,
    Literal,
    Name,
    Where,
    as_array,
    call,
    reduction,
    reshaped,
    scalar,
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
    def owner_axes(self) -> Axes | None:
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
        return row_key(self.keys[0], self.read.type.indexed_by[0], self.scope, w)

    def num_entries(self, w: Writer) -> Literal:
        """Returns how many entries a row has."""
        return w.module.num_entries(self.read.type.indexed_by[0])

    @property
    def along(self) -> Axis | None:
        """The axis that runs along the row that is written, one entry for each place.

        None where entries are found one by one.
        """
        axis = whole_axis(self.keys[0], self.scope) if self.keys else None
        if axis is None or self.owner_axes is None or axis in self.owner_axes:
            return None
        return axis


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
    who = target.who
    bits = random_bits(stream, scope, w) >> 1
    rank = select(scope.mask, bits + 1, 0)
    index = literal(0, "i32") if who is None else who.number
    key = target.key(w)
    axes = union(scope.axes, axes_of(index, rank, value, key))
    at = _flat(select(scope.mask, index, 0), axes, "i32")
    entry: Expression | None = None
    if key is not None:
        entry = _flat(select(scope.mask, as_dtype(key, "i32"), 0), axes, "i32")
    ranks = _flat(rank, axes, "u32")
    place, extent = _lot_places(target, at, entry, w)
    if (target.read.held_by.what, target.read.name) in w.several_lots:
        place = w.bind("place", place)
        ranks = _outranking(target, place, w.bind("rank", ranks), extent, w)
    won = w.bind("won", call("drawn_by_lot", place, ranks, extent))
    current = w.current(target.attribute)
    if who is None and entry is None:
        drawn_first = reduction("argmax", won, (0,))
        drawn = _values(value, target, axes, w)[drawn_first]
        w.assign(target.attribute, Where(reduction("any", won), drawn, current))
        return
    places: tuple[Expression, ...]
    if who is None or entry is None:
        places = (Where(won, place, scalar(extent, "i32")),)
    else:
        past_the_end = scalar(w.module.extent(who.entity_type), "i32")
        places = (Where(won, at, past_the_end), entry)
    new = _values(value, target, axes, w, along_row=entry is None) if value.axes else value.node
    w.assign(target.attribute, written("set_at", current, places, new))


def _lot_places(
    target: Target, at: Expression, entry: Expression | None, w: Writer
) -> tuple[Expression, Expression]:
    """Returns the number of each instance's target among all that it may have, and how many.

    Each entry of each row is one target.
    """
    extent: Expression = Literal(1)
    if target.who is not None:
        extent = w.module.extent(target.who.entity_type)
    if entry is None:
        return at, extent
    num_entries = target.num_entries(w)
    if target.who is None:
        return entry, num_entries
    return at * num_entries + entry, extent * num_entries


def _outranking(
    target: Target,
    place: Expression,
    ranks: Name,
    extent: Expression,
    w: Writer,
) -> Name:
    """Returns the ranks above those that earlier statements drew for a target, others as 0."""
    best: Expression | None = w.best_ranks.get(target.attribute)
    if best is None:
        best = zeros("u32", extent)
    else:
        ranks = w.bind("rank", call("outranking", place, ranks, best))
    w.best_ranks[target.attribute] = w.bind("best", call("best_ranks", place, ranks, best))
    return ranks


def _values(
    value: Value, target: Target, axes: Axes, w: Writer, along_row: bool = False
) -> Expression:
    """Returns the value of each instance, in the order of their numbers.

    along_row: whether one value that a whole row is set to gets a new axis.
    """
    type_ = target.read.type
    levels = () if target.keys else type_.indexed_by
    entries = tuple(map(w.module.num_entries, levels))
    set_extents = w.module.set_extents(type_)
    if value.levels > len(set_extents):
        return _flat(value, axes, value.dtype, (*entries, *set_extents))
    flat = _flat(value, axes, value.dtype, set_extents)
    if along_row and entries and value.levels == len(set_extents):
        return flat[:, None]
    return flat


def _flat(
    value: Value,
    axes: Axes,
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
    return reshaped(full, -1, *inside)


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
        numbers = name[who.number.node] if who.axis is None else name[:-1]
        cell = CellVar(Value(numbers, "i32", who.number.axes), (kind,))
        of_kinds.append(Target(w.module.field(read, kind), cell, keys, read, scope))
    return of_kinds


def _write(target: Target, value: Value, w: Writer) -> None:
    """Writes one field where the scope's mask holds."""
    owner_axes = target.owner_axes
    along = target.along
    key = target.key(w) if along is None else None
    if owner_axes is None or (
        key is not None and any(a.size > 1 for a in without(key.axes, owner_axes))
    ):
        _scatter(target, key, value, w)
        return
    dtype = state_reads.storage(target.declared, w)
    levels = w.module.levels(target.read.type)
    before = Value(w.current(target.attribute), dtype, owner_axes, levels)
    if along is not None:
        before = unrolled(before, along)
    mask = target.scope.mask
    lacking = without(target.scope.axes, before.axes)
    reached = reduce("any", mask, lacking)
    if reached == FALSE:
        return
    value = _of_the_one(value, lacking, mask)
    if key is None:
        after = _whole(before, reached, value)
    else:
        after = _entry(before, reached, _of_the_one(key, lacking, mask), target, value, w)
    if after != before:
        node = after.node if along is None else rolled(after.node, before.axes, along)
        w.assign(target.attribute, node)


def _of_the_one(value: Value, over: Axes, mask: Value) -> Value:
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
        masked = select(mask, as_dtype(value, number), 0)
        return as_dtype(reduce("sum", masked, over), value.dtype)
    keys = tuple(Literal(0) if a in gone else ALL for a in value.axes)
    return replace(value, node=value.node[keys], axes=without(value.axes, gone))


def _whole(before: Value, mask: Value, value: Value) -> Value:
    """Returns the field with the value in its place."""
    if mask != TRUE:
        return select(mask, value, before)
    is_full = value.axes == before.axes and value.levels == before.levels
    if is_full and not value.literal:
        return value
    if not value.axes and not value.levels:
        return replace(before, node=call("jnp.full_like", before.node, value.node))
    rows = aligned(value, before.axes, before.levels)
    return replace(before, node=call("jnp.broadcast_to", rows, Attribute(before.node, "shape")))


def _entry(
    before: Value, mask: Value, key: Value, target: Target, value: Value, w: Writer
) -> Value:
    """Returns the rows of a field with the value in one entry of each."""
    if key.literal:
        new = select(mask, value, taken(before, key.node, before.levels - 1))
        of_sets = {"axis": -2} if before.levels > 1 else {}
        return replace(before, node=call("set_entry", before.node, key.node, new.node, **of_sets))
    entries = w.axis("entry", target.num_entries(w))
    row = replace(before, axes=(*before.axes, entries), levels=before.levels - 1)
    after = select(one_hot(key, entries) & mask, value, row)
    return replace(before, node=after.node)


def _scatter(target: Target, key: Value | None, value: Value, w: Writer) -> None:
    """Writes at computed places; instances that do not happen write past the end."""
    scope = target.scope
    if target.who is None:
        assert key is not None
        index = as_dtype(key, "i32")
        name = "to_entry"
        past_the_end = target.num_entries(w)
        entry = None
    else:
        index = target.who.number
        name = _place(target.who)
        past_the_end = w.module.extent(target.who.entity_type)
        entry = key
    # A place for each instance; an array drops what is written past its end.
    axes = axes_of(index, scope.mask, value, entry)
    at = w.keep(name, broadcast(select(scope.mask, index, past_the_end), axes)).node
    places = (at,) if entry is None else (at, aligned(entry, axes))
    levels = w.module.levels(target.read.type) - (key is not None)
    new = aligned(value, axes, levels) if value.axes else value.node
    current = w.current(target.attribute)
    w.assign(target.attribute, written("set_at", current, places, new))


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
    separate = target.owner_axes or ()  # each member of these has a sum of its own
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
    masked = select(target.scope.mask, value, 0)
    key = target.key(w) if target.along is None else None
    if key is not None:  # a row that has the value at the key's word and 0 elsewhere
        axes = axes_of(masked, key)
        entries = w.axis("entry", target.num_entries(w))
        entry = select(one_hot(key, entries), masked, 0)
        masked = replace(entry, node=aligned(entry, (*axes, entries)), axes=axes, levels=1)
    if is_exact:
        reals = scalar(masked.node, "f32") if masked.literal else masked.node
        masked = Value(call("fixed_point", reals), "i32", masked.axes, masked.levels + 1)
    if target.owner_axes is not None:
        total = _total(target, target.owner_axes, masked, is_exact)
    else:
        assert target.who is not None
        total = _scattered(target, target.who, masked, is_exact, w)
    sums = w.added.setdefault(target.attribute, [])
    sums.append(w.keep(f"{target.attribute}_added", total))


def _total(target: Target, owner_axes: Axes, terms: Value, is_exact: bool) -> Value:
    """Returns the sum of the terms for each member of `owner_axes`, the axes of a field."""
    along = target.along
    kept = owner_axes if along is None else union(owner_axes, (along,))
    total = reduce("sum", terms, without(target.scope.axes, kept))
    if not total.axes and not total.levels:
        return total
    # A row that is the same for all is aligned too: JAX would not know which axis it lacks.
    node = aligned(total, kept)
    if along is None:
        return replace(total, node=node, axes=owner_axes)
    return Value(rolled(node, kept, along), total.dtype, owner_axes, 1 + is_exact)


def _scattered(target: Target, who: Variable, terms: Value, is_exact: bool, w: Writer) -> Value:
    """Returns the sum of the terms for each agent or cell, which are at computed places."""
    index = who.number
    axes = axes_of(index, terms)
    total = reduce("sum", terms, without(target.scope.axes, axes))
    extent = w.module.extent(who.entity_type)
    levels = target.read.type.indexed_by
    none = zeros("f32" if is_exact else total.dtype, extent, *map(w.module.num_entries, levels))
    if is_exact:
        none = call("fixed_point", none)
    sums = written("add_at", none, (spread(index, axes),), aligned(total, axes))
    everybody = Axis(f"all of {target.attribute}", extent.size, 0)
    return Value(sums, total.dtype, (everybody,), len(levels) + is_exact)


def _add_member(s: ir.Add, target: Target, w: Writer) -> None:
    """Adds agents to sets kept as bits: a table of who is added where, folded into bits."""
    mask = target.scope.mask
    who = target.who
    member = w.value(s.value, target.scope)
    key = target.key(w)
    index = member if who is None else who.number
    axes = axes_of(index, member, key, mask)
    # What is not added has a number past the end.
    past_the_end = w.module.agents if who is None else w.module.extent(who.entity_type)
    at = broadcast(select(mask, index, past_the_end), axes)
    at = w.keep("member" if who is None else _place(who), at)
    places: list[Expression] = []
    sizes: list[Literal] = []
    if who is not None:
        places.append(at.node)
        sizes.append(past_the_end)
    if key is not None:
        places.append(aligned(key, axes))
        sizes.append(target.num_entries(w))
    joining = target.scope.variables[s.value.name] if isinstance(s.value, ir.Member) else None
    axis = None if joining is None else joining.axis
    joins_once = axis in axes and all(a.size == 1 for a in axes if a != axis)
    # To a set of the world: who is added at all. Where each instance adds a member of its own once:
    # its bit is added to the set. Else a table of places and members is folded into bits.
    sets: Expression
    if who is None:
        sets = _folded(places, at.node, sizes, w)
    elif axis is not None and joins_once and not w.module.numbers_per_set:
        dtype = w.module.set_dtype
        bits = Value(scalar(Literal(1), dtype) << iota(axis, dtype).node, dtype, (axis,))
        sets = written("add_at", zeros(dtype, *sizes), tuple(places), aligned(bits, axes))
    else:
        sets = _folded(places, aligned(member, axes), sizes, w)
    if target.read.type.indexed_by and key is None:  # to every entry of the row
        sets = sets[None] if who is None else sets[:, None]
    joined_sets = w.keep_node(f"{target.attribute}_joined", sets, w.module.set_dtype)
    w.joined.setdefault(target.attribute, []).append(joined_sets)


def _folded(
    places: list[Expression], member: Expression, sizes: list[Literal], w: Writer
) -> Expression:
    """Returns the sets to which instances add an agent each, as bits.

    places: where each instance adds; sizes: how many places there are.
    """
    empty = zeros("bool", *sizes, w.module.agents)
    table = written("set_at", empty, (*places, member), Literal(True))
    members = w.keep_node("members", table, "bool")
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
        node = _combined("+", node, [total.node for total in sums], attribute, w)
        if is_exact:
            node = call("rounded", node)
        if declared.capped:
            number = float if dtype == "f32" else int
            low = number(declared.type.low)
            node = call("jnp.clip", node, low, number(declared.type.high))
        if stored_dtype not in ("i32", "f32"):
            node = Cast(node, stored_dtype)
        w.assign(attribute, node)
    for attribute, sets in w.joined.items():
        w.assign(attribute, _combined("|", w.current(attribute), sets, attribute, w))


def _combined(
    op: str, node: Expression, terms: list[Expression], attribute: str, w: Writer
) -> Expression:
    """Returns a field together with sums or sets; many are combined step by step."""
    for number, term in enumerate(terms, 1):
        node = joined(op, node, term)
        if number % MOST_NESTED == 0:
            node = w.bind(attribute, node)
    return node
