"""Whom a beam meets, against a search cell by cell. Where beams end: tests/runtime/test_counting.py."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from sjdsl.runtime.line_of_sight import nearest_in_lanes


@pytest.mark.parametrize("lanes", [(1,), (5,), (1, 1, 1), (3, 3, 3), (2, 4, 1, 3)])
def test_the_nearest_of_each_lane(lanes: tuple[int, ...]) -> None:
    random = np.random.default_rng(sum(lanes))
    eligible = random.random((50, 4, sum(lanes))) < random.choice([0, 0.3, 1], (50, 4, 1))
    numbers = random.integers(0, 1000, eligible.shape, np.int32)
    chosen, found = map(
        np.asarray,
        jax.jit(nearest_in_lanes, static_argnums=2)(
            jnp.asarray(eligible), jnp.asarray(numbers), lanes
        ),
    )
    assert (chosen.dtype, found.dtype) == (np.int32, bool)
    assert chosen.shape == found.shape == (50, 4, len(lanes))
    for place in np.ndindex(50, 4):
        for lane, end in enumerate(np.cumsum(lanes)):
            cells = [cell for cell in range(end - lanes[lane], end) if eligible[*place, cell]]
            assert found[*place, lane] == bool(cells)
            assert not cells or chosen[*place, lane] == numbers[*place, cells[0]]
