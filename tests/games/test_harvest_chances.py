"""The chances of Harvest, counted: growth for each number of apples near."""

from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from .chance import BATCH, assert_share, many
from .environments import cells_of, environment, frame_cells

pytestmark = pytest.mark.optimised

GAME = "harvest_open"
SOUTH = [(15, c) for c in range(7)]  # where nothing happens
# chance of growth with so many apples near. Source: the paper's and the released code's figures
GROWTH = {0: 0, 1: 0.001, 2: 0.005, **dict.fromkeys(range(3, 13), 0.025)}
BESIDE_ONE = {
    None: GROWTH[1],
    "socialjax": GROWTH[1],
    "meltingpot": 0.0025,
}  # Source of the second: Melting Pot, the open field


def state_with(fruit: np.ndarray, variant: str | None) -> Any:
    env = environment(GAME, variant)
    _, state = env.reset(jax.random.key(0))
    return state.replace(
        position=jnp.asarray(frame_cells(env, SOUTH)),
        heading=jnp.zeros(7, jnp.int32),
        soil_fruit=jnp.asarray(fruit, jnp.uint8),
    )


@cache
def counter(variant: str | None) -> Any:
    """Counts the cells grown over many steps from one state."""

    def look(before: Any, after: Any, _: Any) -> Any:
        return (before.soil_fruit == 0) & (after.soil_fruit == 1)

    return many(environment(GAME, variant), look)


def near(cells: list[tuple[int, int]], fruit: np.ndarray) -> np.ndarray:
    """Returns for each cell how many of those within a distance of 2 bear an apple, by looking at all of them."""
    return np.array(
        [
            sum(
                int(f)
                for (r, c), f in zip(cells, fruit, strict=True)
                if 0 < (r - a) ** 2 + (c - b) ** 2 <= 4
            )
            for a, b in cells
        ]
    )


@pytest.mark.thorough
@pytest.mark.parametrize(
    "variant", [None, "socialjax", pytest.param("meltingpot", marks=pytest.mark.slow)]
)
def test_growth_for_each_number_of_apples_near(variant: str | None) -> None:
    """Random patches, most of them bare so that one apple near is the common case; told to 6, 6 and 2 parts in a hundred."""
    env = environment(GAME, variant)
    cells = cells_of(env, "soil")
    random = np.random.default_rng(1)
    trials, hits = np.zeros(13), np.zeros(13)
    for seed in range(10):
        fruit = random.random(64) < (0.15 if seed < 8 else 0.5)
        number = near(cells, fruit)
        if (
            variant == "socialjax"
        ):  # released code: the two cells of the last column that have a neighbour below left don't count it
            for cell, below in (((0, 21), (1, 20)), ((7, 21), (8, 20))):
                number[cells.index(cell)] -= fruit[cells.index(below)]
        state = state_with(fruit, variant)
        grown = counter(variant)(seed, state, [6] * 7, env.params, 15)
        assert not grown[fruit].any()
        np.add.at(trials, number[~fruit], 15 * BATCH)
        np.add.at(hits, number[~fruit], grown[~fruit])
    assert hits[0] == 0
    assert trials[0] > 1e6
    assert_share(hits[1], trials[1], BESIDE_ONE[variant], 0.06)
    assert_share(hits[2], trials[2], GROWTH[2], 0.06)
    assert_share(hits[3:].sum(), trials[3:].sum(), GROWTH[3], 0.03)
    for n in range(3, 7):
        assert_share(hits[n], trials[n], GROWTH[n], 0.1)
