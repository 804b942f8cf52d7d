"""Kernels and games inside `jax.shard_map` as it is by default, which checks the types of values that differ between devices."""

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.sharding import AxisType, PartitionSpec

from sjdsl.runtime import movement, placing

WORDS = jnp.arange(40, dtype=jnp.uint32) * jnp.uint32(2_654_435_761)
CELLS = jnp.arange(40, dtype=jnp.int32)
YES = jnp.ones(40, bool)
KERNELS: dict[str, tuple[Callable[..., Any], tuple[Any, ...]]] = {
    "choose": (placing.choose, (YES, WORDS[:5], jnp.int32(3))),
    "place": (placing.place, (CELLS, YES, WORDS[:3], CELLS[:3], YES[:3])),
    "place fitting": (
        placing.place,
        (CELLS, YES, WORDS[:3], CELLS[:3], YES[:3], jnp.ones((3, 40), bool)),
    ),
    "pair": (partial(placing.pair, alike=True), (WORDS.reshape(4, 10)[:, :4],)),
    "pair, many": (partial(placing.pair, alike=False), (jnp.outer(WORDS, WORDS),)),
    "pair reached": (
        partial(placing.pair_reached, num_right=6, alike=False),
        (CELLS[:12].reshape(6, 2) % 6, WORDS[:12].reshape(6, 2)),
    ),
    "move, few": (
        partial(movement._by_spreading, exchange=False),
        (CELLS[:9], CELLS[1:10], WORDS[:9]),
    ),
    "move, many": (partial(movement._by_spreading, exchange=True), (CELLS, CELLS[::-1], WORDS)),
}


def split(function: Callable[..., Any], differs: int, arguments: tuple[Any, ...]) -> Any:
    """Returns what a function returns where only one of its arguments, by its number, differs between devices (of which there is one)."""
    mesh = jax.make_mesh((1,), ("devices",), axis_types=(AxisType.Auto,))
    specs = tuple(
        PartitionSpec("devices") if number == differs else PartitionSpec()
        for number in range(len(arguments))
    )
    given = [
        jnp.asarray(one)[None] if number == differs else one for number, one in enumerate(arguments)
    ]

    def own(*parts: Any) -> Any:
        values = [part[0] if number == differs else part for number, part in enumerate(parts)]
        return jax.tree.map(lambda leaf: leaf[None], function(*values))

    return jax.tree.map(
        lambda leaf: leaf[0],
        jax.jit(jax.shard_map(own, mesh=mesh, in_specs=specs, out_specs=PartitionSpec("devices")))(
            *given
        ),
    )


@pytest.mark.parametrize("name", KERNELS)
def test_a_kernel_whose_arguments_differ_between_devices(name: str) -> None:
    kernel, arguments = KERNELS[name]
    expected = jax.tree.leaves(kernel(*arguments))
    for differs in range(len(arguments)):
        for found, value in zip(
            jax.tree.leaves(split(kernel, differs, arguments)), expected, strict=True
        ):
            np.testing.assert_array_equal(found, value)
