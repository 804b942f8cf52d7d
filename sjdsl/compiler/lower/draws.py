"""Lowers random draws: one number of a stream for every instance, and the distribution made of it."""

from sjdsl.compiler import ir
from sjdsl.compiler.lower.axes import Axis, Value, aligned, as_dtype, binary, both, invert, literal, union, wrapped
from sjdsl.compiler.lower.expressions import lower, real
from sjdsl.compiler.lower.scope import Frame, Writer


def words(stream: int, frame: Frame, extra: tuple[Axis, int] | None = None) -> Value:
    """Returns one word an instance; with `extra` one for each member of that axis too (numbered inside the instance)."""
    digits = [*frame.digits]
    if extra is not None:
        digits.append((Value(f"jnp.arange({extra[0].size}, dtype=jnp.int32)", "i32", (extra[0],)), extra[1]))
    if all(_counts(digit) and (i == 0 or digit.axes[0].size == radix) for i, (digit, radix) in enumerate(digits)):
        axes = tuple(d.axes[0] for d, _ in digits)
        shape = "".join(f", {axis.size}" for axis in axes)
        return Value(f"words(key, 0x{stream:08x}{shape})", "u32", axes)
    number = literal(0, "i32")
    for digit, radix in digits:
        number = digit if number.text == "0" else binary("+", binary("*", number, literal(radix, "i32"), "i32"), digit, "i32")
    return Value(f"words_at(key, 0x{stream:08x}, {_unsigned(number)})", "u32", number.axes)


def _counts(digit: Value) -> bool:
    """Whether a digit simply counts along its axis."""
    return digit.text.startswith("jnp.arange(") and len(digit.axes) == 1


def _unsigned(number: Value) -> str:
    if number.literal:
        return f"jnp.asarray({number.text}, jnp.uint32)"
    return f"{wrapped(number)}.astype(jnp.uint32)"


def chances(s: ir.Chance, frame: Frame, w: Writer) -> tuple[list[Value], Value]:
    """Returns when each branch of a chain happens, and when none does: one word, compared with rising thresholds."""
    word = binary(">>", words(s.stream, frame), literal(1, "u32"), "u32")
    word = w.keep("word", word) if len(s.branches) > 1 or s.otherwise else word
    happens: list[Value] = []
    before: Value | None = None
    for branch in s.branches:
        p = real(branch.test, frame.always(), w)
        if before is None:
            limit = Value(f"threshold({_array(p)})", "u32", p.axes)
        else:
            axes = union(before.axes, p.axes)
            limit = Value(
                f"next_threshold({aligned(before, axes)}, {_array(Value(aligned(p, axes), 'f32', axes, literal=p.literal))})",
                "u32",
                axes,
            )
        if len(s.branches) > 1:
            limit = w.keep("limit", limit)
        hit = binary("<", word, limit, "bool")
        if before is not None:
            hit = both(hit, binary(">=", word, before, "bool"))
        assert hit is not None
        happens.append(w.keep("happens", hit))
        before = limit
    assert before is not None
    last = happens[0] if len(s.branches) == 1 else binary("<", word, before, "bool")
    return happens, invert(last)


def _array(p: Value) -> str:
    return f"jnp.float32({p.text})" if p.literal else p.text


def draw(s: ir.Draw, frame: Frame, w: Writer) -> Value:
    """Returns a drawn number or word."""
    word = words(s.stream, frame)
    if s.words and not s.weights:
        return w.keep(s.name, Value(f"below({word.text}, {len(s.words)}).astype(jnp.uint8)", "u8", word.axes))
    if s.weights:
        return w.keep(s.name, _weighted(s, word, frame, w))
    assert s.low is not None and s.high is not None
    low, high = (as_dtype(lower(x, frame.always(), w), "i32") for x in (s.low, s.high))
    span = literal(int(high.text) - int(low.text) + 1, "i32") if low.literal and high.literal else None
    span = span or binary("+", binary("-", high, low, "i32"), literal(1, "i32"), "i32")
    axes = union(word.axes, span.axes)
    drawn = Value(f"below({aligned(word, axes)}, {aligned(span, axes)})", "i32", axes)
    return w.keep(s.name, binary("+", drawn, low, "i32"))


def _weighted(s: ir.Draw, word: Value, frame: Frame, w: Writer) -> Value:
    shifted = w.keep("word", binary(">>", word, literal(1, "u32"), "u32"))
    total: Value | None = None
    result = literal(0, "i32")
    for weight in s.weights[:-1]:
        p = real(weight, frame.always(), w)
        total = p if total is None else binary("+", total, p, "f32")
        limit = Value(f"threshold({_array(total)})", "u32", total.axes)
        past = as_dtype(binary(">=", shifted, limit, "bool"), "i32")
        result = past if result.text == "0" else binary("+", result, past, "i32")
    return as_dtype(result, "u8")
