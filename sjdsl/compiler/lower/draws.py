"""Lowers random draws: 32 random bits for every instance, and the distribution made of them.

The instances of a statement are numbered: the members of the quantifiers around it are the digits
of the number, the outermost first. Instance i draws number i of the statement's stream.
"""

from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.compiler.lower.axes import (
    Axis,
    Value,
    aligned,
    as_dtype,
    called,
    iota,
    literal,
    without,
)
from sjdsl.compiler.lower.condition_names import value_name
from sjdsl.compiler.lower.expressions import operand, real
from sjdsl.compiler.lower.scope import IterationScope
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    Arange,
    Cast,
    Expression,
    Literal,
    Name,
    as_array,
    call,
)

KEY = Name("key")


def random_bits(stream: int, scope: IterationScope, w: Writer, extra: Axis | None = None) -> Value:
    """Returns 32 random bits for each instance; with `extra`, for each member of that axis too."""
    digits = scope.digits if extra is None else (*scope.digits, (iota(extra), extra.extent))
    if need_no_state(digits):
        axes = tuple(digit.axes[0] for digit, _ in digits)
        extents = [axis.extent for axis in axes]
        return Value(call("random_bits", KEY, w.stream(stream), *extents), "u32", axes)
    number = literal(0, "i32")
    for digit, radix in digits:
        number = number * radix + digit
    unsigned = as_array(number.node, "u32") if number.literal else Cast(number.node, "u32")
    stream_number = w.stream(stream)
    instance = w.keep_node("instance", unsigned, "u32")
    bits = call("random_bits_at", KEY, stream_number, instance)
    return w.keep("word", Value(bits, "u32", number.axes))


def bits_of_each(stream: int, entity_type: ir.EntityType, w: Writer) -> Expression:
    """Returns 32 random bits for each agent, or each mover of a name."""
    return call("random_bits", KEY, w.stream(stream), w.module.extent(entity_type))


def need_no_state(digits: tuple[tuple[Value, Literal], ...]) -> bool:
    """Returns whether instances are numbered in the order of their axes, without gaps.

    Then their random bits are the first of the stream, and don't depend on the state.

    digits: of an instance's number, each with how many values it can have.
    """
    for digit, _ in digits:
        counts_up = isinstance(digit.node, Arange) and len(digit.axes) == 1
        if not counts_up:
            return False
    # The first digit may have fewer values than it could: that leaves no gap between numbers.
    return all(digit.axes[0].size == radix.value for digit, radix in digits[1:])


def chances(s: ir.Chance, scope: IterationScope, w: Writer) -> tuple[list[Value], Value]:
    """Returns when each branch of `chance p {} else chance q {} ...` happens, and when none does.

    One random number is compared with a limit for each branch, which rises from branch to branch: a
    branch happens if the number is below its limit, but not below that of the branch before.
    """
    is_chain = len(s.branches) > 1
    bits = random_bits(s.stream, scope, w) >> 1
    if is_chain or s.otherwise:
        bits = w.keep("word", bits)
    happens: list[Value] = []
    lower: Value | None = None  # the limit of the branch before
    for branch in s.branches:
        if lower is None:
            limit = first_limit(branch.test, scope, w)
        else:
            limit = _next_limit(lower, branch.test, scope, w)
        if is_chain:
            limit = w.keep(_branch_name(branch, "limit"), limit)
        hit = bits < limit
        if lower is not None:
            hit = hit & (bits >= lower)
        name = _branch_name(branch, "happens") if is_chain else "happens"
        happens.append(w.keep(name, hit))
        lower = limit
    assert lower is not None
    any_happens = bits < lower if is_chain else happens[0]
    return happens, ~any_happens


def first_limit(probability: ir.Expr, scope: IterationScope, w: Writer) -> Value:
    """Returns the limit below which a draw makes the first branch of a chain happen."""
    return _threshold(_probability(probability, scope, w))


def _threshold(p: Value) -> Value:
    """Returns the limit below which 31 random bits lie with a probability."""
    return called("threshold", p.array, dtype="u32")


def _next_limit(lower: Value, probability: ir.Expr, scope: IterationScope, w: Writer) -> Value:
    """Returns the limit of a branch. lower: the limit of the branch before it."""
    with w.deciding():
        p = operand(probability, _probability(probability, scope, w), w)
    return called("next_threshold", lower, p.array)


def _branch_name(branch: ir.Branch, noun: str) -> str:
    """Returns a name for a fact about a branch, after its probability if that has a name."""
    name = "" if isinstance(branch.test, ir.Number) else value_name(branch.test)
    return f"{name}_{noun}".strip("_")


def _probability(e: ir.Expr, scope: IterationScope, w: Writer) -> Value:
    """Returns a probability.

    Where only a guard keeps it from being negative, rounding may bring it below 0: it is 0 then.
    """
    with w.deciding():
        p = real(e, scope, w)
    if e.type.low < 0:
        return called("jnp.maximum", p, 0.0)
    return p


def draw(s: ir.Draw, scope: IterationScope, w: Writer) -> Value:
    """Returns a drawn number or enum value, or a row of them if the draw is `by` something."""
    if s.by is None:
        bits = random_bits(s.stream, scope, w)
        return w.keep(s.name, _drawn(s, bits, scope, w))
    entries = w.axis(s.name, w.module.num_entries(s.by))
    bits = random_bits(s.stream, scope, w, entries)
    drawn = _dealt(s, bits) if s.different else _drawn(s, bits, scope, w)
    # The axis of the entries becomes the dimension of the row.
    axes = without(drawn.axes, (entries,))
    row = Value(aligned(drawn, (*axes, entries)), drawn.dtype, axes, row_dims=1)
    return w.keep(s.name, row)


def _dealt(s: ir.Draw, bits: Value) -> Value:
    """Returns different enum values, or different whole numbers, along the last axis of `bits`."""
    if s.words:
        return as_dtype(called("dealt_values", bits, len(s.words), dtype="i32"), "u8")
    low = int(s.type.low)
    num_values = int(s.type.high) - low + 1
    return called("dealt_values", bits, num_values, dtype="i32") + low


def _drawn(s: ir.Draw, bits: Value, scope: IterationScope, w: Writer) -> Value:
    """Returns the number, or the number of the enum value, that random bits stand for."""
    if s.weights:
        return _weighted(s, bits, scope, w)
    if s.words:
        return as_dtype(called("below", bits, len(s.words), dtype="i32"), "u8")
    assert s.low is not None and s.high is not None
    if s.type.kind == "real":
        return _between(s, s.low, s.high, bits, scope, w)
    low = as_dtype(w.value(s.low, scope), "i32")
    high = as_dtype(w.value(s.high, scope), "i32")
    num_values = high - low + 1
    return called("below", bits, num_values, dtype="i32") + low


def _between(
    s: ir.Draw, low: ir.Expr, high: ir.Expr, bits: Value, scope: IterationScope, w: Writer
) -> Value:
    """Returns a real drawn between two others."""
    with w.deciding(s.name in w.module.deciding.variables):
        start = operand(low, real(low, scope, w), w)
        end = operand(high, real(high, scope, w), w)
        offset = (end - start) * called("unit", bits, dtype="f32")
        if w.exact:
            offset = called("exactly", offset)
        return start + offset


def _weighted(s: ir.Draw, bits: Value, scope: IterationScope, w: Writer) -> Value:
    """Returns an enum value's number, or a whole number, drawn with weights.

    The place drawn is the number of partial sums of the weights that the random number reaches.
    """
    shifted = w.keep("word", bits >> 1)
    partial_sum: Value | None = None
    place = literal(0, "i32")
    for weight in s.weights[:-1]:
        with w.deciding():
            p = _probability(weight, scope, w)
            partial_sum = p if partial_sum is None else _add_weight(partial_sum, weight, p, w)
        place = place + as_dtype(shifted >= _threshold(partial_sum), "i32")
    if s.numbers:
        values = list(s.numbers)
        comment = f"what `{s.name}` is drawn from"
        table = w.module.constant(f"{s.name}_values", values, comment, "i32")
        return replace(place, node=table[place.node])
    return as_dtype(place, "u8")


def _add_weight(total: Value, weight: ir.Expr, p: Value, w: Writer) -> Value:
    """Returns the sum of some weights and the next one."""
    if not total.literal:
        total = called("exactly", total)
    return total + operand(weight, p, w)
