"""Operators on nodes and on values with named axes, against what NumPy computes of the same."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from sjdsl.compiler.emit.expressions import text
from sjdsl.compiler.lower.axes import FALSE, TRUE, Axis, Value, literal, select
from sjdsl.compiler.program.expressions import Name

A = np.array([7, 3, 2])
B = np.array([1, 4, 2])
OPERATIONS: list[Callable[[Any, Any], Any]] = [
    lambda a, b: a + b * 2 - 1,
    lambda a, b: a // b + a % b,
    lambda a, b: (a & 3) | (b << 1),
    lambda a, b: a >> 1 & b,
    lambda a, b: (a < b) | ~(a >= b) & (a > 2),
    lambda a, b: a[:, None] - b[None, :],
    lambda a, b: a[..., None] + b[:-1],
    lambda a, b: a[b - 2] + a[1],
]


@pytest.mark.parametrize("operation", OPERATIONS)
def test_operators_on_nodes_compute_what_they_do_on_arrays(
    operation: Callable[[Any, Any], Any],
) -> None:
    node = operation(Name("a"), Name("b"))
    np.testing.assert_array_equal(eval(text(node), {"a": A, "b": B}), operation(A, B))


def test_eq_and_ne_compare_entries() -> None:
    a = Name("a")
    b = Name("b")
    np.testing.assert_array_equal(eval(text(a.eq(b)), {"a": A, "b": B}), A == B)
    np.testing.assert_array_equal(eval(text(a.ne(b)), {"a": A, "b": B}), A != B)
    assert a != b and a == Name("a")


def test_nodes_cannot_be_iterated() -> None:
    with pytest.raises(TypeError):
        list(Name("a"))  # type: ignore[call-overload]


def test_values_are_aligned_by_the_names_of_their_axes() -> None:
    x = Axis("x", 3, 1)
    y = Axis("y", 3, 2)
    across = Value(Name("b"), "i32", (y,)) - Value(Name("a"), "i32", (x,))
    assert (across.axes, across.dtype) == ((x, y), "i32")
    np.testing.assert_array_equal(
        eval(text(across.node), {"a": A, "b": B}), B[None, :] - A[:, None]
    )
    assert (across < 2).dtype == "bool"
    along = Value(Name("a"), "i32", (x,)) + Value(Name("b"), "i32", (x,))
    np.testing.assert_array_equal(eval(text(along.node), {"a": A, "b": B}), A + B)


def test_known_operands_are_folded() -> None:
    test = Value(Name("test"), "bool")
    assert test & TRUE == TRUE & test == test | FALSE == test
    assert test & FALSE == FALSE and TRUE | test == TRUE
    number = Value(Name("number"), "i32")
    assert number + 0 == number * 1 == number
    assert literal(7, "i32") // 2 == literal(3, "i32")
    assert select(TRUE, number, 5) == number and select(FALSE, number, 5) == literal(5, "i32")
