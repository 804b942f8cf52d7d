"""Array values of the lowering: operands are lined up by the names of their axes, and what changes nothing is not written."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sjdsl.compiler.emit.expressions import text
from sjdsl.compiler.lower.axes import (
    FALSE,
    TRUE,
    Axis,
    Value,
    as_dtype,
    binary,
    both,
    either,
    indexed,
    invert,
    iota,
    literal,
    reduce,
    select,
    spread,
    union,
)
from sjdsl.compiler.program.expressions import ALL, NEW_AXIS, REST, Name, path

AXES = (Axis("agent1", 2, 1, "NUM_AGENTS"), Axis("cell2", 3, 2), Axis("lane3", 4, 3))
WORDS = 5  # entries of a row


def named(name: str, axes: tuple[Axis, ...], levels: int = 0, dtype: Any = "i32") -> Value:
    return Value(Name(name), dtype, axes, levels)


def array_of(name: str, value: Value) -> np.ndarray:
    """Returns numbers for a named value; sums of them stay exact."""
    shape = (*(a.size for a in value.axes), *[WORDS] * value.levels)
    return np.random.default_rng(len(name) + len(shape)).integers(-9, 9, shape).astype(np.int32)


def evaluated(value: Value, given: dict[str, Value]) -> np.ndarray:
    names = {name: array_of(name, v) for name, v in given.items()}
    return np.asarray(eval(text(value.node), {"jnp": np, "NUM_AGENTS": 2, **names}))


def over_all(name: str, value: Value) -> np.ndarray:
    """Returns a named value with all the axes there are, in order: what is meant, without a word about indices."""
    array, levels = array_of(name, value), value.levels
    for place, axis in enumerate(AXES):
        if axis not in value.axes:
            array = np.repeat(np.expand_dims(array, place), axis.size, axis=place)
    return array if levels else array[..., None]


some_axes = st.sets(st.sampled_from(AXES)).map(lambda found: union(tuple(found)))
values = st.tuples(some_axes, st.integers(0, 1))


@settings(max_examples=50, deadline=None)
@given(values, values, st.sampled_from(["+", "*", "<", "=="]))
def test_operands_are_lined_up_by_name(a: tuple[Any, int], b: tuple[Any, int], op: str) -> None:
    given = {"left": named("left", *a), "right_one": named("right_one", *b)}
    result = binary(op, *given.values(), "bool" if op in ("<", "==") else "i32")
    found, left, right = evaluated(result, given), *(over_all(name, v) for name, v in given.items())
    meant = {"+": left + right, "*": left * right, "<": left < right, "==": left == right}[op]
    absent = tuple(i for i, axis in enumerate(AXES) if axis not in result.axes)
    meant = (
        np.take(meant, 0, axis=absent[0])
        if len(absent) == 1
        else meant[tuple(0 if i in absent else slice(None) for i in range(3))]
    )
    np.testing.assert_array_equal(found, meant if result.levels else meant[..., 0])


@settings(max_examples=50, deadline=None)
@given(some_axes, some_axes, st.sets(st.sampled_from(AXES)))
def test_a_sum_counts_every_instance(of_test: Any, of_value: Any, gone: set[Axis]) -> None:
    given = {"test": named("test", of_test), "value": named("value", of_value)}
    chosen = select(
        Value(binary(">", given["test"], literal(0, "i32"), "bool").node, "bool", of_test),
        given["value"],
        literal(7, "i32"),
    )
    over = union(tuple(gone))
    result = reduce("sum", chosen, over)
    whole = np.where(over_all("test", given["test"]) > 0, over_all("value", given["value"]), 7)[
        ..., 0
    ]
    meant = whole.sum(axis=tuple(AXES.index(a) for a in over))
    kept = [a for a in AXES if a not in over]
    absent = tuple(0 if a not in result.axes else slice(None) for a in kept)
    np.testing.assert_array_equal(evaluated(result, given), meant[absent])


def test_what_changes_nothing_is_not_written() -> None:
    x = named("x", AXES[:1])
    zero, one = literal(0, "i32"), literal(1, "i32")
    for op, other in (("+", zero), ("-", zero), ("*", one), ("<<", zero), (">>", zero)):
        assert binary(op, x, other, "i32") == x
    assert binary("+", zero, x, "i32") == x and binary("*", one, x, "i32") == x
    assert binary("-", zero, x, "i32") != x
    real = named("r", (), 0, "f32")
    assert binary("*", real, literal(1, "f32"), "f32") == real
    assert binary("+", real, literal(0, "f32"), "f32") != real  # -0.0 + 0.0 is 0.0
    assert as_dtype(x, "i32") == x
    assert spread(x, AXES[:1]) == x.node


def test_conditions_are_as_short_as_they_can_be() -> None:
    a, b, c = (named(name, AXES[:1], 0, "bool") for name in "abc")
    assert both(TRUE, a) == a and both(a, FALSE, b) == FALSE and both(TRUE) == both() == TRUE
    assert either([FALSE, a]) == a and either([a, TRUE]) == TRUE and either([]) == FALSE
    nested = both(a, both(b, both(a, c)))
    assert text(nested.node) == "a & b & a & c"
    same = binary("==", named("x", ()), literal(3, "i32"), "bool")
    assert (
        text(invert(same).node) == "x != 3"
        and invert(invert(a)) == a
        and text(invert(a).node) == "~a"
    )
    assert select(TRUE, a, b) == a and select(FALSE, a, b) == b
    assert text(select(a, literal(1, "i32"), literal(0, "i32")).node) == "a.astype(jnp.int32)"


def test_bytes_are_compared_as_bytes() -> None:
    stored = as_dtype(Value(path("state.left"), "u8", AXES[:1]), "i32")
    assert text(binary("<", stored, literal(200, "i32"), "bool").node) == "state.left < 200"
    assert (
        text(binary("<", stored, literal(256, "i32"), "bool").node)
        == "state.left.astype(jnp.int32) < 256"
    )
    assert (
        text(binary(">", stored, literal(-1, "i32"), "bool").node)
        == "state.left.astype(jnp.int32) > -1"
    )
    held = as_dtype(Value(path("state.held"), "bool", AXES[:1]), "i32")
    assert (
        text(binary("==", held, literal(1, "i32"), "bool").node)
        == "state.held.astype(jnp.int32) == 1"
    )


def test_new_axes_are_added_at_once() -> None:
    x = Name("x")
    column = indexed(x, (ALL, NEW_AXIS))
    assert text(indexed(column, (REST, NEW_AXIS))) == "x[:, None, None]"
    assert text(indexed(column, (NEW_AXIS, ALL, ALL))) == "x[None, :, None]"
    assert text(indexed(column, (ALL, literal(0, "i32").node))) == "x[:, None][:, 0]"
    assert (
        text(indexed(as_dtype(Value(x, "u8"), "i32").node, (ALL, NEW_AXIS)))
        == "x[:, None].astype(jnp.int32)"
    )


@pytest.mark.parametrize(
    ("axis", "expected"),
    [
        (AXES[0], "jnp.arange(NUM_AGENTS, dtype=jnp.int32)"),
        (AXES[1], "jnp.arange(3, dtype=jnp.int32)"),
    ],
)
def test_axes_are_printed_by_their_constants(axis: Axis, expected: str) -> None:
    assert text(iota(axis).node) == expected
