"""Programs that are rewritten for GPUs: the same values, without scatters and without reductions that XLA makes kernels of."""

import re
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.bench.compilation import count_operations
from sjdsl.runtime.bits import pack, unpack
from sjdsl.runtime.gpu_program import rewritten

REDUCTIONS = {
    "sum": lambda x: jnp.sum(x, axis=1, dtype=x.dtype),
    "any": lambda x: jnp.any(x > 0, axis=1),
    "all": lambda x: jnp.all(x > 0, axis=1),
    "most of bools": lambda x: jnp.max(x > 0, axis=1),
    "least of bools": lambda x: jnp.min(x > 0, axis=1),
    "max": lambda x: jnp.max(x, axis=1),
    "min": lambda x: jnp.min(x, axis=1),
    "argmax": lambda x: jnp.argmax(x, axis=1),
    "argmin": lambda x: jnp.argmin(x, axis=1),
    "the sum of two axes": lambda x: jnp.sum(x, axis=(0, 1), dtype=x.dtype),
    "two at once": lambda x: jax.lax.reduce(
        (x, -x), (x.dtype.type(0), x.dtype.type(0)), _together, (1,)
    ),
}


def _together(one: tuple[Any, Any], other: tuple[Any, Any]) -> tuple[Any, Any]:
    return jnp.maximum(one[0], other[0]), jnp.minimum(one[1], other[1])


def same_if_rewritten(function: Callable[..., Any], *arrays: Any) -> str:
    """Returns the StableHLO of the rewritten function, which has the same values, for a batch too."""
    found, expected = jax.jit(rewritten(function))(*arrays), jax.jit(function)(*arrays)
    jax.tree.map(np.testing.assert_array_equal, found, expected)
    assert jax.tree.map(lambda x: x.dtype, found) == jax.tree.map(lambda x: x.dtype, expected)
    (batch,) = jax.tree.leaves(
        jax.jit(jax.vmap(rewritten(function)))(*(array[None] for array in arrays))
    )[:1]
    np.testing.assert_array_equal(batch[0], jax.tree.leaves(expected)[0])
    return jax.jit(rewritten(function)).lower(*arrays).as_text()


@pytest.mark.parametrize("dtype", [jnp.int32, jnp.float32])
@pytest.mark.parametrize("kind", REDUCTIONS)
def test_reductions(kind: str, dtype: jnp.dtype) -> None:
    """Of 4 entries, longer by one that changes nothing, also where all are negative or none is; of 5, as they are."""
    for size in (4, 5):
        values = (
            np.random.default_rng(size).integers(-3, 4, (6, size)) - 4 * (np.arange(6) < 2)[:, None]
        )
        text = same_if_rewritten(REDUCTIONS[kind], jnp.asarray(values).astype(dtype))
        assert count_operations(text, ("pad",))["pad"] == (
            kind != "the sum of two axes" and size == 4
        ) * (1 + (kind == "two at once"))


SCATTERS = {
    "one value": lambda x, to, _: x.at[to[:, 0]].set(7, mode="drop"),
    "one place": lambda x, to, _: x.at[to[1, 1]].set(7, mode="drop"),
    "values": lambda x, to, new: x.at[to[:, 0]].set(new, mode="drop"),
    "rows": lambda x, to, new: (
        jnp.stack([x, x + 1], axis=1).at[to].set(new[:, None, None], mode="drop")
    ),
    "entries": lambda x, to, _: (
        jnp.zeros((6, 4), x.dtype).at[to[:, 0], to[:, 1]].set(1, mode="drop")
    ),
    "a column": lambda x, _, new: jnp.stack([x, x], axis=1).at[:, 1].add(new[0]),
    "sums": lambda x, to, new: x.at[to].add(new[:, None], mode="drop"),
}


@pytest.mark.parametrize("dtype", [jnp.uint8, jnp.float32])
@pytest.mark.parametrize("kind", SCATTERS)
def test_scatters(kind: str, dtype: jnp.dtype) -> None:
    """Some to one place, of which the last writes; some past the end, or from the end."""
    to = jnp.array([[3, 0], [1, 2], [3, 1], [6, 3], [-1, 9]], jnp.int32)
    new = jnp.array([1, 20, 3, 40, 5]).astype(dtype)
    text = same_if_rewritten(
        SCATTERS[kind], jnp.arange(6).astype(dtype), to, new / 3 if dtype == jnp.float32 else new
    )
    assert count_operations(text, ("scatter",))["scatter"] == 0


def test_a_scatter_of_many_stays() -> None:
    many = jnp.arange(100, dtype=jnp.int32)
    text = same_if_rewritten(lambda x, to: x.at[to].set(x, mode="drop"), many, many)
    assert count_operations(text, ("scatter",))["scatter"] == 1


def test_what_is_called_twice_is_one_function() -> None:
    inner = jax.jit(lambda x: jnp.any(x > 0, axis=1))
    text = same_if_rewritten(lambda x: inner(x) & inner(-x), jnp.arange(8).reshape(2, 4))
    assert text.count("call @") == 2
    assert text.count("stablehlo.pad") == 1


def test_sums_of_constants_are_constants() -> None:
    """Also in a function that is given one, once for each; a sum of what isn't known stays."""

    @jax.jit
    def packed(members: jax.Array, x: jax.Array) -> jax.Array:
        return jnp.sum(members.astype(jnp.int32) << jnp.arange(members.size, dtype=jnp.int32)) + x

    def both(x: jax.Array) -> jax.Array:
        return packed(jnp.full(5, True), x) + packed(jnp.arange(5) < 2, x)

    assert count_operations(same_if_rewritten(both, jnp.int32(7)), ("reduce",))["reduce"] == 0
    text = same_if_rewritten(lambda x: packed(x > 0, x[0]), jnp.arange(5, dtype=jnp.int32))
    assert count_operations(text, ("reduce",))["reduce"] == 1


def test_masks_that_were_packed_stay_packed() -> None:
    """What was set where a mask of words holds is packed as it was before, and counted as bits."""

    def grow(
        cells: jax.Array, first: jax.Array, second: jax.Array, free: jax.Array, active: jax.Array
    ) -> Any:
        cells = jnp.where(active & unpack(first, 40), 3, cells)
        members = pack((cells == 0) & free)
        cells = jnp.where(~unpack(second, 40) | ~active, 1, cells)
        return (
            members,
            pack(cells == 2),
            pack(cells == 1),
            jnp.sum(cells == 3, dtype=jnp.int32),
            jnp.sum(cells == 0, dtype=jnp.int32),
            cells,
        )

    random = np.random.default_rng(0)
    for active in (True, False):
        cells, free = (
            jnp.asarray(random.integers(0, 4, 40), jnp.uint8),
            jnp.asarray(random.random(40) < 0.5),
        )
        words = (
            jnp.asarray(random.integers(0, 2**32, 2) & (2**32 - 1, 2**8 - 1), jnp.uint32)
            for _ in range(2)
        )
        text = same_if_rewritten(grow, cells, *words, free, jnp.bool_(active))
        assert (
            len(re.findall(r"call @.* -> tensor<2xui32>", text)) == 1 + 5
        )  # free, and for each question which of the cells had that number at first
        assert count_operations(text, ("reduce",))["reduce"] == 1  # in `pack`


def test_masks_that_are_not_of_words_are_packed() -> None:
    """Also where what is written differs from cell to cell, or is not known."""

    def grow(cells: jax.Array, words: jax.Array, value: jax.Array) -> Any:
        here = unpack(words, 40)
        return (
            pack(jnp.where(here, value, cells) == 3),
            pack(jnp.where(here, jnp.arange(40), cells) == 3),
            pack(jnp.where(cells > 1, 3, cells) == 3),
        )

    text = same_if_rewritten(
        grow, jnp.arange(40, dtype=jnp.int32) % 5, jnp.uint32([12345, 67]), jnp.int32(3)
    )
    assert len(re.findall(r"call @.* -> tensor<2xui32>", text)) == 3
