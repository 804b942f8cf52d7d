"""Lowers random draws: one number of a stream for every instance, and the distribution made of it."""

from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.compiler.lower.axes import (
    Axis,
    Value,
    aligned,
    as_dtype,
    binary,
    invert,
    iota,
    literal,
    union,
)
from sjdsl.compiler.lower.condition_names import value_name
from sjdsl.compiler.lower.expressions import operand, real
from sjdsl.compiler.lower.scope import IterationScope
from sjdsl.compiler.lower.writer import Writer
from sjdsl.compiler.program.expressions import (
    Arange,
    Cast,
    Expression,
    Index,
    Literal,
    Name,
    as_array,
    call,
    constant,
    scalar,
)

KEY = Name("key")


def random_bits(stream: int, scope: IterationScope, w: Writer, extra: Axis | None = None) -> Value:
    """Returns 32 random bits an instance; with `extra` for each member of that axis too (numbered inside the instance)."""
    digits = scope.digits if extra is None else (*scope.digits, (iota(extra), extra.extent))
    if need_no_state(digits):
        axes = tuple(digit.axes[0] for digit, _ in digits)
        return Value(
            call("random_bits", KEY, w.stream(stream), *(a.extent for a in axes)), "u32", axes
        )
    number = literal(0, "i32")
    for digit, radix in digits:
        number = binary("+", binary("*", number, Value(radix, "i32"), "i32"), digit, "i32")
    bits = call(
        "random_bits_at",
        KEY,
        w.stream(stream),
        w.keep(
            "instance",
            Value(
                as_array(number.node, "u32") if number.literal else Cast(number.node, "u32"),
                "u32",
                number.axes,
            ),
        ).node,
    )
    return w.keep("word", Value(bits, "u32", number.axes))


def need_no_state(digits: tuple[tuple[Value, Literal], ...]) -> bool:
    """Whether random bits depend on the key alone: each digit of the index simply counts along its axis."""
    return all(
        isinstance(digit.node, Arange)
        and len(digit.axes) == 1
        and (place == 0 or digit.axes[0].size == radix.value)
        for place, (digit, radix) in enumerate(digits)
    )


def chances(s: ir.Chance, scope: IterationScope, w: Writer) -> tuple[list[Value], Value]:
    """Returns when each branch of a chain happens, and when none does: one word, compared with rising thresholds."""
    word = binary(">>", random_bits(s.stream, scope, w), literal(1, "u32"), "u32")
    word = w.keep("word", word) if len(s.branches) > 1 or s.otherwise else word
    happens: list[Value] = []
    before: Value | None = None
    for branch in s.branches:
        if before is None:
            limit = first_limit(branch.test, scope, w)
        else:
            with w.deciding():
                p = operand(branch.test, _probability(branch.test, scope, w), w)
            axes = union(before.axes, p.axes)
            limit = Value(
                call("next_threshold", aligned(before, axes), _array(p, axes)), "u32", axes
            )
        if len(s.branches) > 1:
            limit = w.keep(_named(branch, "limit"), limit)
        hit = binary("<", word, limit, "bool")
        if before is not None:
            hit = binary("&", hit, binary(">=", word, before, "bool"), "bool")
        happens.append(w.keep(_named(branch, "happens") if len(s.branches) > 1 else "happens", hit))
        before = limit
    assert before is not None
    last = happens[0] if len(s.branches) == 1 else binary("<", word, before, "bool")
    return happens, invert(last)


def first_limit(probability: ir.Expr, scope: IterationScope, w: Writer) -> Value:
    """Returns the limit below which a draw makes the first branch of a chain happen."""
    p = _probability(probability, scope, w)
    return Value(call("threshold", _array(p)), "u32", p.axes)


def _named(branch: ir.Branch, what: str) -> str:
    """Returns a name for a fact about one of several branches, after its probability if that has a name."""
    name = "" if isinstance(branch.test, ir.Number) else value_name(branch.test)
    return f"{name}_{what}".strip("_")


def _probability(e: ir.Expr, scope: IterationScope, w: Writer) -> Value:
    """Returns a probability; where a guard alone keeps it from being negative, what rounding has brought below 0 is 0."""
    with w.deciding():
        p = real(e, scope.always(), w)
    return replace(p, node=call("jnp.maximum", p.node, Literal(0.0))) if e.type.low < 0 else p


def _array(p: Value, axes: tuple[Axis, ...] | None = None) -> Expression:
    return scalar(p.node, "f32") if p.literal else aligned(p, p.axes if axes is None else axes)


def draw(s: ir.Draw, scope: IterationScope, w: Writer) -> Value:
    """Returns a drawn number or word."""
    word = random_bits(s.stream, scope, w)
    if s.words and not s.weights:
        return w.keep(
            s.name,
            Value(Cast(call("below", word.node, Literal(len(s.words))), "u8"), "u8", word.axes),
        )
    if s.weights:
        return w.keep(s.name, _weighted(s, word, scope, w))
    assert s.low is not None and s.high is not None
    if s.type.kind == "real":
        return w.keep(s.name, _between(s, s.low, s.high, word, scope, w))
    low, high = (as_dtype(w.value(x, scope.always()), "i32") for x in (s.low, s.high))
    span = binary("+", binary("-", high, low, "i32"), literal(1, "i32"), "i32")
    axes = union(word.axes, span.axes)
    drawn = Value(call("below", aligned(word, axes), aligned(span, axes)), "i32", axes)
    return w.keep(s.name, binary("+", drawn, low, "i32"))


def _between(
    s: ir.Draw, low: ir.Expr, high: ir.Expr, word: Value, scope: IterationScope, w: Writer
) -> Value:
    """Returns a real drawn between two others."""
    with w.deciding(s.name in w.module.deciding.variables):
        start, end = (operand(x, real(x, scope.always(), w), w) for x in (low, high))
        place = replace(word, node=call("unit", word.node), dtype="f32")
        length = binary("-", end, start, "f32")
        way = binary("*", length, place, "f32")
        if w.exact:
            way = replace(way, node=call("exactly", way.node))
        return binary("+", start, way, "f32")


def _weighted(s: ir.Draw, word: Value, scope: IterationScope, w: Writer) -> Value:
    shifted = w.keep("word", binary(">>", word, literal(1, "u32"), "u32"))
    total: Value | None = None
    result = literal(0, "i32")
    for weight in s.weights[:-1]:
        with w.deciding():
            p = _probability(weight, scope, w)
            total = p if total is None else _more(total, weight, p, w)
        limit = Value(call("threshold", _array(total)), "u32", total.axes)
        result = binary("+", result, as_dtype(binary(">=", shifted, limit, "bool"), "i32"), "i32")
    if s.numbers:
        table = w.module.constant(
            f"{s.name}_values", constant(list(s.numbers)), f"what `{s.name}` is drawn from", "i32"
        )
        return replace(result, node=Index(table, (result.node,)))
    return as_dtype(result, "u8")


def _more(total: Value, weight: ir.Expr, p: Value, w: Writer) -> Value:
    """Returns the sum of some weights and the next one."""
    before = total if total.literal else replace(total, node=call("exactly", total.node))
    return binary("+", before, operand(weight, p, w), "f32")
