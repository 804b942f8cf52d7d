"""Lowers `set` and `add`.

Where the instances of a statement are the entries of the field itself, in order, a new value is
selected entry by entry:

    each water where rusty { set water.state = clean }    jnp.where(rusty, CLEAN, state.water_state)

Where they name entries by computed numbers, the value is scattered, past the end by instances that
do not happen: `set_at(state.water_state, to_water, CLEAN)`. `set ... by lot` draws which of the
instances that name one entry writes it. What is added is collected, and written when a phase ends.
"""

from collections import Counter
from dataclasses import replace

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
    common,
    iota,
    joined,
    literal,
    one_hot,
    reduce,
    select,
    size_of,
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
    """One field that a statement writes: `votes` of `a` at the key `yes` in `set a.votes[yes] = 1`.

    declared: the declaration of the field. read: the expression that names the field.
    who: the agents or cells whose field it is; None for a field of the world.
    keys: of the entry in the field's row; none for the whole field.
    scope: the instances that write.
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
        """The axes of the stored field along which the instances write each entry once, in order.

        It is the axis of the owners, or no axis for a field of the world. None if the owners are
        computed numbers, so that the value must be scattered.
        """
        if self.who is None:
            return ()
        return None if self.who.axis is None else (self.who.axis,)

    def key(self, w: Writer) -> Value | None:
        """Returns the place of the written entry in its row; None if the whole field is written."""
        if not self.keys:
            return None
        return row_key(self.keys[0], self.read.type.indexed_by[0], self.scope, w)

    def num_entries(self, w: Writer) -> Literal:
        """Returns how many entries a row has."""
        return w.module.num_entries(self.read.type.indexed_by[0])

    @property
    def along(self) -> Axis | None:
        """The axis of the instances along which they write each entry of a row once, in order.

        It is that of b in `each agent as a { each agent as b { set a.trust[b] = 1 } }`. None if the
        key is any other expression.
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
    """Writes `set target = value by lot`: of the instances with one target, one writes.

    Each instance draws a rank; the greatest of those with one target wins. If several statements of
    the phase set the field by lot, all of their instances take part.

    Args:
      stream: of the ranks.
    """
    scope = target.scope
    who = target.who
    bits = random_bits(stream, scope, w) >> 1
    rank = select(scope.mask, bits + 1, 0)  # 0: does not take part
    owner_number = literal(0, "i32") if who is None else who.number
    key = target.key(w)
    # From here on, everything has one entry for each instance, on a single axis.
    axes = union(scope.axes, axes_of(owner_number, rank, value, key))
    owners = _flat(select(scope.mask, owner_number, 0), axes, "i32")
    entries: Expression | None = None
    if key is not None:
        entries = _flat(select(scope.mask, as_dtype(key, "i32"), 0), axes, "i32")
    ranks = _flat(rank, axes, "u32")
    target_numbers, num_targets = _numbered_targets(target, owners, entries, w)
    if (target.read.held_by.what, target.read.name) in w.several_lots:
        target_numbers = w.bind("place", target_numbers)
        ranks = _outranking(target, target_numbers, w.bind("rank", ranks), num_targets, w)
    won = w.bind("won", call("drawn_by_lot", target_numbers, ranks, num_targets))
    current = w.current(target.attribute)
    if who is None and entries is None:
        winner = reduction("argmax", won, (0,))
        drawn = _values(value, target, axes, w)[winner]
        w.assign(target.attribute, Where(reduction("any", won), drawn, current))
        return
    places: tuple[Expression, ...]
    if who is None or entries is None:
        places = (Where(won, target_numbers, scalar(num_targets, "i32")),)
    else:
        past_the_end = scalar(w.module.extent(who.entity_type), "i32")
        places = (Where(won, owners, past_the_end), entries)
    new = value.node
    if value.axes:
        new = _values(value, target, axes, w, along_row=entries is None)
    w.assign(target.attribute, written("set_at", current, places, new))


def _numbered_targets(
    target: Target, owners: Expression, entries: Expression | None, w: Writer
) -> tuple[Expression, Expression]:
    """Returns which target each instance writes, as a number, and how many targets there are.

    A target is a field of one owner, or each entry of it if single entries are written.

    Args:
      owners, entries: the numbers of each instance's owner and entry, on a single axis.
    """
    num_owners: Expression = Literal(1)
    if target.who is not None:
        num_owners = w.module.extent(target.who.entity_type)
    if entries is None:
        return owners, num_owners
    num_entries = target.num_entries(w)
    if target.who is None:
        return entries, num_entries
    return owners * num_entries + entries, num_owners * num_entries


def _outranking(
    target: Target,
    target_numbers: Expression,
    ranks: Name,
    num_targets: Expression,
    w: Writer,
) -> Name:
    """Returns the ranks, but 0 where an earlier statement of the phase drew a greater one.

    Notes the best rank of each target for the statements after this one.
    """
    best: Expression | None = w.best_ranks.get(target.attribute)
    if best is None:
        best = zeros("u32", num_targets)
    else:
        ranks = w.bind("rank", call("outranking", target_numbers, ranks, best))
    best_now = call("best_ranks", target_numbers, ranks, best)
    w.best_ranks[target.attribute] = w.bind("best", best_now)
    return ranks


def _values(
    value: Value, target: Target, axes: Axes, w: Writer, along_row: bool = False
) -> Expression:
    """Returns the value of each instance on a single axis, before those of one value.

    along_row: whether one number to which a whole row is set gets an axis for the row.
    """
    type_ = target.read.type
    set_extents = w.module.set_extents(type_)
    index_sets = () if target.keys else type_.indexed_by
    row_extents = tuple(map(w.module.num_entries, index_sets))
    is_row = value.row_dims > len(set_extents)
    if is_row:
        return _flat(value, axes, value.dtype, (*row_extents, *set_extents))
    flat = _flat(value, axes, value.dtype, set_extents)
    if along_row and row_extents and value.row_dims == len(set_extents):
        return flat[:, None]
    return flat


def _flat(
    value: Value,
    axes: Axes,
    dtype: DType,
    inside: tuple[Expression, ...] = (),
) -> Expression:
    """Returns the values over all axes on a single one: `[I, *inside]` for I instances.

    inside: the extents of one value.
    """
    node = aligned(value, axes, value.row_dims)
    if value.literal:
        node = as_array(node, dtype)
    extents = [axis.extent for axis in axes]
    return reshaped(Broadcast(node, (*extents, *inside)), -1, *inside)


def set_(s: ir.Set, scope: IterationScope, w: Writer) -> None:
    """Writes `set target = value`."""
    decides = w.module.deciding.has_field(written_field(s.target))
    with w.deciding(decides):
        value = stored_value(s.value, s.target, scope, w)
    fields = targets(s.target, scope, w)
    if len(fields) > 1 and not value.literal:
        value = w.keep("written", value)
    for target in fields:
        stored = as_dtype(value, state_reads.storage(target.declared, w))
        if s.lot is not None:
            write_by_lot(s.lot, target, stored, w)
        else:
            _write(target, stored, w)


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
    """Returns the fields that a write to an expression changes.

    It is one field, except for a cell of a group of kinds: each kind has a field of its own.
    """
    keys: tuple[ir.Expr, ...] = ()
    read = target
    while isinstance(read, ir.At):
        keys = (read.key, *keys)
        read = read.row
    assert isinstance(read, ir.FieldRead)
    who = None if read.owner is None else owner(read.owner, scope, w)
    if not isinstance(who, CellVar) or len(who.kinds) == 1:
        return [Target(w.module.field(read), who, keys, read, scope)]
    layout = w.layout
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
    """Writes a value to one field where the scope's mask holds: selected, or scattered."""
    owner_axes = target.owner_axes
    along = target.along
    key = target.key(w) if along is None else None
    if owner_axes is None:
        _write_at_places(target, key, value, w)
        return
    if key is not None and size_of(without(key.axes, owner_axes)) > 1:
        _write_at_places(target, key, value, w)
        return
    dtype = state_reads.storage(target.declared, w)
    row_dims = w.module.row_dims(target.read.type)
    before = Value(w.current(target.attribute), dtype, owner_axes, row_dims)
    if along is not None:
        before = unrolled(before, along)
    # The statement may be inside quantifiers that the field has no axis for.
    mask = target.scope.mask
    lacking = without(target.scope.axes, before.axes)
    is_written = reduce("any", mask, lacking)
    if is_written == FALSE:
        return
    value = _of_the_one(value, lacking, mask)
    if key is None:
        after = _whole(before, is_written, value)
    else:
        after = _entry(before, is_written, _of_the_one(key, lacking, mask), target, value, w)
    if after != before:
        node = after.node if along is None else rolled(after.node, before.axes, along)
        w.assign(target.attribute, node)


def _of_the_one(value: Value, over: Axes, mask: Value) -> Value:
    """Returns the value or key of the one instance that writes, without the axes of `over`.

    These are the scope's axes that the target lacks. A value that differs along them is refused
    unless at most one instance writes each target: then they have length 1, or `mask` holds for one
    instance at most.
    """
    differing = common(over, value.axes)
    if not differing:
        return value
    if size_of(differing) > 1:
        assert mask != TRUE, over
        # All but one instance add 0.
        number: DType = value.dtype if value.dtype in ("f32", "u32") else "i32"
        masked = select(mask, as_dtype(value, number), 0)
        return as_dtype(reduce("sum", masked, over), value.dtype)
    keys = tuple(Literal(0) if axis in differing else ALL for axis in value.axes)
    return replace(value, node=value.node[keys], axes=without(value.axes, differing))


def _whole(before: Value, mask: Value, value: Value) -> Value:
    """Returns a field with the value wherever the mask holds."""
    if mask != TRUE:
        return select(mask, value, before)
    is_full = value.axes == before.axes and value.row_dims == before.row_dims
    if is_full and not value.literal:
        return value
    if not value.axes and not value.row_dims:
        return replace(before, node=call("jnp.full_like", before.node, value.node))
    rows = aligned(value, before.axes, before.row_dims)
    return replace(before, node=call("jnp.broadcast_to", rows, Attribute(before.node, "shape")))


def _entry(
    before: Value, mask: Value, key: Value, target: Target, value: Value, w: Writer
) -> Value:
    """Returns a field of rows with the value at the key's entry where the mask holds."""
    if key.literal:
        old = taken(before, key.node, before.row_dims - 1)
        new = select(mask, value, old)
        keywords = {"axis": -2} if before.row_dims > 1 else {}  # behind it are the numbers of a set
        node = call("set_entry", before.node, key.node, new.node, **keywords)
        return replace(before, node=node)
    entries = w.axis("entry", target.num_entries(w))
    row = replace(before, axes=(*before.axes, entries), row_dims=before.row_dims - 1)
    after = select(one_hot(key, entries) & mask, value, row)
    return replace(before, node=after.node)


def _write_at_places(target: Target, key: Value | None, value: Value, w: Writer) -> None:
    """Writes the value of each instance at the place that it computes.

    A place is `[owner]`, `[entry]` of a row of the world, or `[owner, entry]`. Instances that don't
    happen write past the end, which JAX drops.
    """
    scope = target.scope
    if target.who is None:
        assert key is not None
        first = as_dtype(key, "i32")
        name = "to_entry"
        past_the_end = target.num_entries(w)
        second = None
    else:
        first = target.who.number
        name = _place(target.who)
        past_the_end = w.module.extent(target.who.entity_type)
        second = key
    axes = axes_of(first, scope.mask, value, second)
    first_places = w.keep(name, broadcast(select(scope.mask, first, past_the_end), axes)).node
    places: tuple[Expression, ...] = (first_places,)
    if second is not None:
        places = (first_places, aligned(second, axes))
    row_dims = w.module.row_dims(target.read.type) - (key is not None)
    new = aligned(value, axes, row_dims) if value.axes else value.node
    current = w.current(target.attribute)
    w.assign(target.attribute, written("set_at", current, places, new))


def _place(who: Variable) -> str:
    """Returns the name, in generated code, of the numbers of those who are written to."""
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
    summed = without(target.scope.axes, separate)
    terms = w.terms.get(target.attribute, 0) + size_of(summed)
    if terms >= MOST_TERMS:
        feature = (
            f"{MOST_TERMS:,} or more additions in a phase to a real field that decides something"
        )
        raise NotSupported(feature, s.origin, "add up in several phases, or count in whole numbers")
    w.terms[target.attribute] = terms


def _add_number(target: Target, value: Value, is_exact: bool, w: Writer) -> None:
    """Collects what the instances of an `add` add to a field, summed for each of its entries.

    is_exact: whether reals are summed as fixed-point numbers, whose digits are one more dimension.
    """
    terms = select(target.scope.mask, value, 0)
    key = target.key(w) if target.along is None else None
    if key is not None:  # a row that has the term at the key's entry and 0 elsewhere
        axes = axes_of(terms, key)
        entries = w.axis("entry", target.num_entries(w))
        row = select(one_hot(key, entries), terms, 0)
        terms = replace(row, node=aligned(row, (*axes, entries)), axes=axes, row_dims=1)
    if is_exact:
        digits = call("fixed_point", terms.array.node)
        terms = Value(digits, "i32", terms.axes, terms.row_dims + 1)
    if target.owner_axes is not None:
        total = _total(target, target.owner_axes, terms, is_exact)
    else:
        assert target.who is not None
        total = _scattered(target, target.who, terms, is_exact, w)
    sums = w.added.setdefault(target.attribute, [])
    sums.append(w.keep(f"{target.attribute}_added", total).node)


def _total(target: Target, owner_axes: Axes, terms: Value, is_exact: bool) -> Value:
    """Returns the sum of the terms for each owner, who are along the `owner_axes` of a field."""
    along = target.along
    kept = owner_axes if along is None else union(owner_axes, (along,))
    total = reduce("sum", terms, without(target.scope.axes, kept))
    if not total.axes and not total.row_dims:
        return total
    # A row that is the same for all is aligned too: JAX would not know which axis it lacks.
    node = aligned(total, kept)
    if along is None:
        return replace(total, node=node, axes=owner_axes)
    return Value(rolled(node, kept, along), total.dtype, owner_axes, 1 + is_exact)


def _scattered(target: Target, who: Variable, terms: Value, is_exact: bool, w: Writer) -> Value:
    """Returns the sum of the terms for each owner, whom instances name by computed numbers."""
    axes = axes_of(who.number, terms)
    total = reduce("sum", terms, without(target.scope.axes, axes))
    extent = w.module.extent(who.entity_type)
    row = map(w.module.num_entries, target.read.type.indexed_by)
    dtype = "f32" if is_exact else total.dtype
    none = zeros(dtype, extent, *row)
    if is_exact:
        none = call("fixed_point", none)
    places = spread(who.number, axes)
    sums = written("add_at", none, (places,), aligned(total, axes))
    everybody = Axis(f"all of {target.attribute}", extent.size, 0)
    row_dims = len(target.read.type.indexed_by) + is_exact
    return Value(sums, total.dtype, (everybody,), row_dims)


def _add_member(s: ir.Add, target: Target, w: Writer) -> None:
    """Collects the agents that the instances of an `add` add to sets, which are kept as bits."""
    mask = target.scope.mask
    who = target.who
    member = w.value(s.value, target.scope)
    key = target.key(w)
    # The number that is past the end for instances that do not happen: the set's owner's, or in a
    # set of the world that of the agent that is added.
    number = member if who is None else who.number
    past_the_end = w.module.agents if who is None else w.module.extent(who.entity_type)
    axes = axes_of(number, member, key, mask)
    masked_number = broadcast(select(mask, number, past_the_end), axes)
    masked_number = w.keep("member" if who is None else _place(who), masked_number)
    places: list[Expression] = []  # of the set to which each instance adds
    sizes: list[Literal] = []
    if who is not None:
        places.append(masked_number.node)
        sizes.append(past_the_end)
    if key is not None:
        places.append(aligned(key, axes))
        sizes.append(target.num_entries(w))
    axis = None
    if isinstance(s.value, ir.Member):
        axis = target.scope.variables[s.value.name].axis
    adds_each_once = axis in axes and size_of(axes) == axis.size
    sets: Expression
    if who is None:
        sets = _folded(places, masked_number.node, sizes, w)
    elif axis is not None and adds_each_once and not w.module.numbers_per_set:
        # Each agent is added by one instance: the sum of their bits is the set.
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
    """Returns the sets to which instances add an agent each, as bits, by way of a table of bools.

    Args:
      places: along each axis of the sets, which one each instance adds to; none for a single set.
      member: the agent that each instance adds.
      sizes: how long each axis of the sets is.
    """
    empty = zeros("bool", *sizes, w.module.agents)
    table = written("set_at", empty, (*places, member), Literal(True))
    members = w.keep_node("members", table, "bool")
    if w.module.numbers_per_set:
        return call("pack", members)
    return call("as_bits", members, DTYPES[w.module.set_dtype])


def finish(w: Writer) -> None:
    """Writes what the `add`s of a phase have collected: sums, clipped if capped, and sets."""
    declared_by_attribute = {attribute_name(field): field for field in all_fields(w.game)}
    for attribute, sums in w.added.items():
        declared = declared_by_attribute[attribute]
        stored_dtype = state_reads.storage(declared, w)
        is_whole = declared.type.kind == "int"
        before = Value(w.current(attribute), stored_dtype)
        node = as_dtype(before, "i32" if is_whole else "f32").node
        is_exact = attribute in w.terms
        if is_exact:
            node = call("fixed_point", node)
        node = _combined("+", node, sums, attribute, w)
        if is_exact:
            node = call("rounded", node)
        if declared.capped:
            number = int if is_whole else float
            low = number(declared.type.low)
            high = number(declared.type.high)
            node = call("jnp.clip", node, low, high)
        if stored_dtype not in ("i32", "f32"):
            node = Cast(node, stored_dtype)
        w.assign(attribute, node)
    for attribute, sets in w.joined.items():
        w.assign(attribute, _combined("|", w.current(attribute), sets, attribute, w))


def _combined(
    op: str, node: Expression, terms: list[Expression], attribute: str, w: Writer
) -> Expression:
    """Returns `node op term op term ...`.

    Of very many terms some are combined at a time, under the attribute's name.
    """
    for number, term in enumerate(terms, 1):
        node = joined(op, node, term)
        if number % MOST_NESTED == 0:
            node = w.bind(attribute, node)
    return node
