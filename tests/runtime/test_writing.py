"""Writing a few entries, in both forms, against a loop over the writers."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.bench.compilation import count_operations
from sjdsl.runtime.forms import forced
from sjdsl.runtime.writing import add_at, add_to_entry, set_at, set_entry

PLACES = np.array([[3, 0], [1, 2], [5, 4], [6, 9], [-2, 12]], np.int32)  # some past an end
CASES: dict[str, tuple[tuple[int, ...], tuple[np.ndarray, ...], tuple[int, ...]]] = {
    # the shape of the values, the places, the shape of what is written
    "a number for all": ((6,), (PLACES[:, 0],), ()),
    "a number each": ((6,), (PLACES[:, 0],), (5,)),
    "rows": ((6, 3), (PLACES[:, 0],), (5, 3)),
    "one row for all": ((6, 3), (PLACES[:, 0],), (3,)),
    "entries of rows": ((6, 4), (PLACES[:, 0], PLACES[:, 1]), (5,)),
    "one place": ((6,), (np.array(2, np.int32),), ()),
    "writers of two axes": ((9,), (PLACES,), (5, 2)),
    "nobody": ((6,), (np.zeros(0, np.int32),), (0,)),
}


def in_a_loop(values: np.ndarray, places: Any, new: np.ndarray, adds: bool) -> np.ndarray:
    result = values.copy()
    numbers = np.broadcast_arrays(*places)
    entry = values.shape[len(numbers) :]
    spread = np.broadcast_to(new, (*numbers[0].shape, *entry))
    for writer in np.ndindex(numbers[0].shape):
        place = tuple(int(number[writer]) for number in numbers)
        if all(-size <= one < size for one, size in zip(place, values.shape, strict=False)):
            result[place] = spread[writer] + (result[place] if adds else 0)
    return result


@pytest.mark.usefixtures("form")
@pytest.mark.parametrize("dtype", ["uint8", "float32"])
@pytest.mark.parametrize("adds", [False, True])
@pytest.mark.parametrize("case", CASES)
def test_entries_are_written_one_after_the_other(case: str, adds: bool, dtype: str) -> None:
    shape, places, of_new = CASES[case]
    random = np.random.default_rng(1)
    values = random.integers(0, 9, shape).astype(dtype)
    new = random.integers(0, 9, of_new).astype(dtype)
    kernel = add_at if adds else set_at
    keys = tuple(map(jnp.asarray, places)) if len(places) > 1 else jnp.asarray(places[0])
    result = kernel(jnp.asarray(values), keys, jnp.asarray(new))
    assert result.dtype == dtype
    np.testing.assert_array_equal(result, in_a_loop(values, places, new, adds))


@pytest.mark.usefixtures("form")
def test_amounts_for_one_place_are_all_added() -> None:
    result = add_at(jnp.zeros(3, jnp.int32), jnp.array([1, 1, 2, 1, 3]), jnp.arange(5))
    assert result.tolist() == [0, 4, 2]


@pytest.mark.usefixtures("form")
def test_one_of_the_places_may_be_a_number() -> None:
    result = set_at(jnp.zeros((2, 3), jnp.int32), (1, jnp.array([0, 2])), 7)
    assert result.tolist() == [[0, 0, 0], [7, 0, 7]]


@pytest.mark.parametrize("axis", [-1, -2])
def test_one_entry_of_each_row(axis: int) -> None:
    values = np.arange(24, dtype=np.uint8).reshape(2, 3, 4)
    new = np.full(np.delete(values.shape, axis), 100, np.uint8)
    where = (..., 1) if axis == -1 else (..., 1, slice(None))
    replaced, increased = values.copy(), values.copy()
    replaced[where] = new
    increased[where] += new
    np.testing.assert_array_equal(set_entry(jnp.asarray(values), 1, new, axis), replaced)
    np.testing.assert_array_equal(add_to_entry(jnp.asarray(values), 1, new, axis), increased)
    number = set_entry(jnp.arange(3, dtype=jnp.uint8), 2, 0)
    assert number.tolist() == [0, 1, 0]


@pytest.mark.parametrize(("writers", "scatters"), [(5, 0), (100, 1)])
def test_a_gpu_compares_unless_there_are_many_writers(writers: int, scatters: int) -> None:
    numbers = jnp.arange(writers, dtype=jnp.int32)
    with forced("gpu"):
        text = jax.jit(lambda x: set_at(x, x, x)).lower(numbers).as_text()
    assert count_operations(text, ("scatter",))["scatter"] == scatters
