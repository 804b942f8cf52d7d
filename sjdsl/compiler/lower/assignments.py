"""Lowers `set` and `add`: by selection where the target is the axis itself, by scatter where its index is computed, or by lot."""

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
    binary,
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
from sjdsl.compiler.program import expressions as array

MOST_NESTED = 100  # additions in one expression, through which Python goes recursively
MOST_TERMS = 2**19  # of an exact sum: `runtime/exact_reals.py`


class Target(Record):
    """One field that a statement writes: of whom (None: the world), at which keys of its row, in which instances."""

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
        """The axis of those whose field it is, none for the world; None if they are computed numbers."""
        if self.who is None:
            return ()
        return None if self.who.axis is None else (self.who.axis,)

    def key(self, w: Writer) -> Value | None:
        """Returns the place of the entry of a row that is written; None for all of it."""
        return (
            row_key(self.keys[0], self.read.type.by[0], self.scope.always(), w)
            if self.keys
            else None
        )

    @property
    def along(self) -> Axis | None:
        """The axis that runs along the row that is written, one entry for each place; None where entries are found one by one."""
        axis = whole_axis(self.keys[0], self.scope) if self.keys else None
        return (
            axis
            if axis is not None and self.own_axes is not None and axis not in self.own_axes
            else None
        )


def past_the_end(who: Variable, w: Writer) -> Value:
    """Returns the number after that of the last agent, or cell of its kinds: what is written there is dropped."""
    return Value(w.module.extent(who.sort), "i32")


def fields_of_several_lots(phase: ir.Phase) -> frozenset[tuple[str, str]]:
    """Returns the fields, by holder and name, that several statements of a phase set by lot."""
    sets = [
        written_field(s.target)
        for s in ir.walk(phase)
        if isinstance(s, ir.Set) and s.lot is not None
    ]
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
    entry = (
        None
        if key is None
        else _flat(select(scope.mask, as_dtype(key, "i32"), literal(0, "i32")), axes, "i32")
    )
    place, ranks = at, _flat(rank, axes, "u32")
    extent: array.Expression = (
        array.Literal(1) if target.who is None else w.module.extent(target.who.sort)
    )
    if entry is not None:
        words = w.module.num_entries(target.read.type.by[0])
        place = (
            entry if target.who is None else array.Binary("+", array.Binary("*", at, words), entry)
        )
        extent = words if target.who is None else array.Binary("*", extent, words)
    if (
        target.read.held_by.what,
        target.read.name,
    ) in w.several_lots:  # only ranks above those that earlier statements drew count
        place, ranks = w.bind("place", place), w.bind("rank", ranks)
        best: array.Expression | None = w.best_ranks.get(target.attribute)
        if best is not None:
            ranks = w.bind("rank", array.call("outranking", place, ranks, best))
        best = best or array.call("jnp.zeros", extent, array.DTYPES["u32"])
        w.best_ranks[target.attribute] = w.bind(
            "best", array.call("best_ranks", place, ranks, best)
        )
    won = w.bind("won", array.call("drawn_by_lot", place, ranks, extent))
    if target.who is None and entry is None:
        drawn = array.Index(
            _values(value, target, axes, w), (array.reduction("argmax", won, (0,)),)
        )
        w.assign(
            target.attribute,
            array.Where(array.reduction("any", won), drawn, w.current(target.attribute)),
        )
        return
    past = (
        w.module.num_entries(target.read.type.by[0])
        if target.who is None
        else past_the_end(target.who, w).node
    )
    mine = place if target.who is None or entry is None else at
    keys = (
        array.Where(won, mine, array.scalar(past, "i32")),
        *([entry] if target.who is not None and entry is not None else []),
    )
    new = _values(value, target, axes, w, along_row=entry is None) if value.axes else value.node
    w.assign(target.attribute, array.written("set_at", w.current(target.attribute), keys, new))


def _values(
    value: Value, target: Target, axes: tuple[Axis, ...], w: Writer, along_row: bool = False
) -> array.Expression:
    """Returns the value of each instance; one value that a whole row is set to stands beside a new axis."""
    type_ = target.read.type if not target.keys else target.read.type.model_copy(update={"by": ()})
    words = [w.module.num_entries(level) for level in type_.by]
    large = [array.Literal(w.module.set_words)] * (w.module.levels(type_) - len(words))
    flat = _flat(
        value, axes, value.dtype, tuple([*words, *large] if value.levels > len(large) else large)
    )
    return (
        array.Index(flat, (array.ALL, array.NEW_AXIS))
        if along_row and words and value.levels == len(large)
        else flat
    )


def _flat(
    value: Value,
    axes: tuple[Axis, ...],
    dtype: array.DType,
    inside: tuple[array.Expression, ...] = (),
) -> array.Expression:
    """Returns a value for each instance, in the order of their numbers. `inside`: extents of the value's own axes."""
    extents = (*(a.extent for a in axes), *inside)
    full = array.Broadcast(
        array.as_array(aligned(value, axes), dtype)
        if value.literal
        else aligned(value, axes, value.levels),
        extents,
    )
    return array.Call(array.Attribute(full, "reshape"), (array.Literal(-1), *inside))


def set_(s: ir.Set, scope: IterationScope, w: Writer) -> None:
    """Writes `set target = value`."""
    with w.deciding(w.module.deciding.has_field(written_field(s.target))):
        value = stored_value(s.value, s.target, scope, w)
    written = targets(s.target, scope, w)
    if len(written) > 1 and not value.literal:
        value = w.keep("written", value)
    for target in written:
        kept = as_dtype(value, state_reads.storage(target.declared, w))
        if s.lot is not None:
            write_by_lot(s.lot, target, kept, w)
        else:
            _write(target, kept, w)


def stored_value(e: ir.Expr, target: ir.Expr, scope: IterationScope, w: Writer) -> Value:
    """Returns a value as the field keeps it: words of its own set, agents as numbers, nobody as the empty set."""
    if isinstance(e, ir.Nobody):
        return literal(0, w.module.set_dtype) if target.type.kind == "agents" else nobody(w)
    if (
        isinstance(e, ir.Case) and e.type.kind == "word"
    ):  # the words of the field at once, not those of the arms first
        e = e.model_copy(update={"type": target.type})
    if target.type.kind == "cell":
        return state_reads.kept_cell(e, scope, w)
    value = w.value(e, scope.always())
    match target.type.kind:
        case "word":
            return to_words(value, e.type.words, target.type.words, w, declared_by(target, w))
        case "real":
            return as_dtype(value, "f32")
        case _:
            return value


def targets(target: ir.Expr, scope: IterationScope, w: Writer) -> list[Target]:
    """Returns the fields a write reaches, each with whose it is: one, or one for each kind of a group that is on the map."""
    keys: tuple[ir.Expr, ...] = ()
    while isinstance(target, ir.At):
        keys, target = (target.key, *keys), target.row
    assert isinstance(target, ir.FieldRead)
    read, who = target, None if target.owner is None else owner(target.owner, scope, w)
    if not isinstance(who, CellVar) or len(who.kinds) == 1:
        return [Target(w.module.field(read), who, keys, read, scope)]
    found = []
    layout = w.module.layout
    there = [
        kind for kind in who.kinds if layout.num_cells((kind,))
    ]  # of others there is no cell that could be written
    if len(there) > 1:  # once for all kinds
        scope = replace(scope, mask=w.keep("active", scope.mask))
    for kind in there:
        table = layout.numbers_table(who.kinds, kind)
        comment = f"number among {kind} of each cell of the group; past the end: none"
        name = w.module.constant(f"{'_'.join(who.kinds)}_to_{kind}", table, comment)
        key = array.Slice(None, array.Literal(-1)) if who.axis is not None else who.site.node
        cell = CellVar(Value(array.Index(name, (key,)), "i32", who.site.axes), (kind,))
        found.append(Target(w.module.field(read, kind), cell, keys, read, scope))
    return found


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
    """Returns a value or key without `over`, the axes of the scope that the target lacks: that of the one instance that writes.

    It differs along them only if one instance at most reaches each target (else the write is refused): they are lanes of shapes
    with one lane, or `mask` holds for one instance at most.
    """
    gone = tuple(a for a in over if a in value.axes)
    if not gone:
        return value
    if any(a.size > 1 for a in gone):  # the sum is the value of the one instance that happens
        assert mask != TRUE, over
        number: array.DType = value.dtype if value.dtype in ("f32", "u32") else "i32"
        return as_dtype(
            reduce("sum", select(mask, as_dtype(value, number), literal(0, number)), over),
            value.dtype,
        )
    kept = tuple(a for a in value.axes if a not in gone)
    return replace(
        value,
        node=array.Index(
            value.node, tuple(array.Literal(0) if a in gone else array.ALL for a in value.axes)
        ),
        axes=kept,
    )


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
        return replace(before, node=array.call("jnp.full_like", before.node, value.node))
    if key is None:
        rows = aligned(value, before.axes, before.levels)
        return replace(
            before, node=array.call("jnp.broadcast_to", rows, array.Attribute(before.node, "shape"))
        )
    if key.literal:
        new = select(mask, value, taken(before, key.node, before.levels - 1))
        of_words = {"axis": array.constant(-2)} if before.levels > 1 else {}
        return replace(
            before, node=array.call("set_entry", before.node, key.node, new.node, **of_words)
        )
    hit = _entries_of_word(key, before.axes, target, w)
    if mask != TRUE:
        hit = array.Binary("&", hit, _for_each_word(mask, before.axes))
    if before.levels > 1:  # of large sets
        words = array.Index(hit, (array.REST, array.NEW_AXIS))
        return replace(
            before, node=array.Where(words, aligned(value, before.axes, before.levels), before.node)
        )
    return replace(before, node=array.Where(hit, _for_each_word(value, before.axes), before.node))


def _entries_of_word(
    key: Value, axes: tuple[Axis, ...], target: Target, w: Writer
) -> array.Expression:
    """Returns which entries of the rows are those of a word that is computed."""
    words = w.module.num_entries(target.read.type.by[0])
    hit = array.call("one_hot", aligned(key, axes), words)
    if axes and not key.axes:
        return array.Index(hit, (*[array.NEW_AXIS] * len(axes), array.ALL))
    return hit


def _for_each_word(value: Value, axes: tuple[Axis, ...]) -> array.Expression:
    """Returns a value with one more axis, for the words of a row; what has no axes is the same for all."""
    return indexed(aligned(value, axes), (array.REST, array.NEW_AXIS)) if value.axes else value.node


def _scatter(target: Target, key: Value | None, value: Value, w: Writer) -> None:
    """Writes at computed places; instances that do not happen write past the end."""
    scope = target.scope
    if target.who is None:
        assert key is not None
        index, name, rest = as_dtype(key, "i32"), "to_entry", None
        past = Value(w.module.num_entries(target.read.type.by[0]), "i32")
    else:
        index, name, rest, past = (
            target.who.number,
            _place(target.who),
            key,
            past_the_end(target.who, w),
        )
    axes = union(index.axes, scope.mask.axes, value.axes, () if rest is None else rest.axes)
    at = w.keep(name, Value(spread(select(scope.mask, index, past), axes), "i32", axes))
    keys = (at.node, *([] if rest is None else [aligned(rest, axes)]))
    levels = w.module.levels(target.read.type) - (key is not None)
    new = aligned(value, axes, levels) if value.axes else value.node
    w.assign(target.attribute, array.written("set_at", w.current(target.attribute), keys, new))


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
        with w.deciding(decides):
            value = as_dtype(
                w.value(s.value, scope.always()),
                "f32" if target.read.type.kind == "real" else "i32",
            )
        is_exact = decides and value.dtype == "f32"
        if is_exact:
            _count_terms(target, s, w)
        _add_number(target, value, is_exact, w)


def _count_terms(target: Target, s: ir.Add, w: Writer) -> None:
    """Counts the terms of an exact sum, of which there is room for so many."""
    apart = target.own_axes or ()  # each member of these has a sum of its own
    summed = prod(axis.size for axis in target.scope.axes if axis not in apart)
    terms = w.terms.get(target.attribute, 0) + summed
    if terms >= MOST_TERMS:
        wanted = (
            f"{MOST_TERMS:,} or more additions in a phase to a real field that decides something"
        )
        raise NotSupported(wanted, s.origin, "add up in several phases, or count in whole numbers")
    w.terms[target.attribute] = terms


def _add_number(target: Target, value: Value, is_exact: bool, w: Writer) -> None:
    """Collects the sums of a number over the instances. is_exact: of reals as fixed-point numbers, whose digits are a level more."""
    scope = target.scope
    if scope.mask == TRUE or not value.levels:
        masked = select(scope.mask, value, literal(0, value.dtype))
    else:
        axes = union(scope.mask.axes, value.axes)
        test = aligned(scope.mask, axes, value.levels) if scope.mask.axes else scope.mask.node
        masked = replace(
            value, node=array.Where(test, _row_aligned(value, axes), array.Literal(0)), axes=axes
        )
    sums = w.added.setdefault(target.attribute, [])
    own = target.own_axes
    key = target.key(w) if own is None or target.along is None else None
    if key is not None:
        axes = union(
            masked.axes, key.axes
        )  # a row that has the value at the key's word and 0 elsewhere
        zero = array.scalar(literal(0, masked.dtype).node, masked.dtype)
        row = array.Where(
            _entries_of_word(key, axes, target, w), _for_each_word(masked, axes), zero
        )
        masked = Value(row, masked.dtype, axes, 1)
    if is_exact:
        given = array.scalar(masked.node, "f32") if masked.literal else masked.node
        masked = Value(array.call("fixed_point", given), "i32", masked.axes, masked.levels + 1)
    if own is not None and target.along is not None:
        entries = union(own, (target.along,))
        total = reduce("sum", masked, tuple(a for a in scope.axes if a not in entries))
        is_array = bool(total.axes or total.levels)
        node = (
            rolled(_row_aligned(total, entries), entries, target.along) if is_array else total.node
        )
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
        ):  # a row that is the same for all is lined up too: JAX does not guess which axis is missing
            total = replace(total, node=_row_aligned(total, own), axes=own)
        sums.append(w.keep(f"{target.attribute}_added", total))
        return
    assert target.who is not None
    index = target.who.number
    axes = union(index.axes, masked.axes)
    total = reduce("sum", masked, tuple(a for a in scope.axes if a not in axes))
    extent = w.module.extent(target.who.sort)
    dtype = "f32" if is_exact else total.dtype
    zeros = array.call(
        "jnp.zeros",
        array.shape_of((extent, *map(w.module.num_entries, target.read.type.by))),
        array.DTYPES[dtype],
    )
    if is_exact:
        zeros = array.call("fixed_point", zeros)
    amount = _row_aligned(total, axes) if total.axes or total.levels else total.node
    shape = (Axis(f"all of {target.attribute}", extent.size, 0),)
    places = (spread(index, axes) if axes else index.node,)
    sets = array.written("add_at", zeros, places, amount)
    sums.append(
        w.keep(
            f"{target.attribute}_added",
            Value(sets, total.dtype, shape, len(target.read.type.by) + is_exact),
        )
    )


def _row_aligned(value: Value, axes: tuple[Axis, ...]) -> array.Expression:
    """Returns a value lined up with axes, its levels last."""
    if value.axes == axes:
        return value.node
    return array.Index(
        value.node,
        (
            *(array.ALL if a in value.axes else array.NEW_AXIS for a in axes),
            *[array.ALL] * value.levels,
        ),
    )


def _add_member(s: ir.Add, target: Target, w: Writer) -> None:
    """Adds agents to sets kept as bits: a table of who is added where, folded into bits."""
    scope, who = target.scope, target.who
    member = w.value(s.value, scope.always())
    joining = scope.variables[s.value.name] if isinstance(s.value, ir.Member) else None
    dtype, words = w.module.set_dtype, w.module.set_words
    keys = [x for x in (target.key(w),) if x is not None]
    around = union(member.axes, *(k.axes for k in keys), scope.mask.axes)
    sizes = [w.module.num_entries(target.read.type.by[0]) for _ in keys]
    sets: array.Expression
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
                array.Binary("<<", array.scalar(array.Literal(1), dtype), iota(itself, dtype).node),
                dtype,
                (itself,),
            )
            zeros = array.call("jnp.zeros", array.shape_of(tuple(extents)), array.DTYPES[dtype])
            sets = array.written("add_at", zeros, tuple(places), aligned(bits, axes))
        else:
            sets = _folded(places, aligned(member, axes), extents, w)
    if target.read.type.by and not keys:  # to every entry of the row
        sets = array.Index(sets, (*[array.ALL] * (who is not None), array.NEW_AXIS))
    joined_sets = w.keep(f"{target.attribute}_joined", Value(sets, dtype))
    w.joined.setdefault(target.attribute, []).append(joined_sets.node)


def _folded(
    places: list[array.Expression], member: array.Expression, sizes: list[array.Literal], w: Writer
) -> array.Expression:
    """Returns the sets in which each instance's agent is at each instance's place: a table of truths, folded into bits."""
    empty = array.call("jnp.zeros", array.shape_of((*sizes, w.module.agents)), array.Name("bool"))
    table = array.written("set_at", empty, (*places, member), array.Literal(True))
    members = w.keep("members", Value(table, "bool")).node
    if w.module.set_words:
        return array.call("pack", members)
    return array.call("as_bits", members, array.DTYPES[w.module.set_dtype])


def finish(w: Writer) -> None:
    """Applies the sums of the phase, brings capped fields into their range, and joins sets."""
    for attribute, sums in w.added.items():
        declared = next(f for f in all_fields(w.module.game) if attribute_name(f) == attribute)
        dtype = state_reads.storage(declared, w)
        node = as_dtype(
            Value(w.current(attribute), dtype), "i32" if declared.type.kind == "int" else "f32"
        ).node
        is_exact = attribute in w.terms
        node = array.call("fixed_point", node) if is_exact else node
        for number, total in enumerate(sums, 1):
            node = joined("+", node, total.node)
            if number % MOST_NESTED == 0:
                node = w.bind(attribute, node)
        node = array.call("rounded", node) if is_exact else node
        if declared.capped:
            node = array.call(
                "jnp.clip",
                node,
                array.Literal(int(declared.type.low)),
                array.Literal(int(declared.type.high)),
            )
        if dtype not in ("i32", "f32"):
            node = array.Cast(node, dtype)
        w.assign(attribute, node)
    for attribute, sets in w.joined.items():
        node = w.current(attribute)
        for number, added in enumerate(sets, 1):
            node = array.Binary("|", node, added)
            if number % MOST_NESTED == 0:
                node = w.bind(attribute, node)
        w.assign(attribute, node)
