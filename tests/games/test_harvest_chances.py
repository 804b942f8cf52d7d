"""The chances of Harvest, counted: growth for each number of apples near, homes, headings."""

from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from .chance import BATCH, assert_share, assert_uniform, many
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


def state_with(
    places: list[tuple[int, int]],
    headings: list[int] | None = None,
    fruit: Any = None,
    variant: str | None = None,
) -> Any:
    env = environment(GAME, variant)
    _, state = env.reset(jax.random.key(0))
    changed = {} if fruit is None else {"soil_fruit": jnp.asarray(fruit, jnp.uint8)}
    return state.replace(
        position=jnp.asarray(frame_cells(env, places)),
        heading=jnp.array(headings or [0] * 7, jnp.int32),
        **changed,
    )


@cache
def counter(variant: str | None) -> Any:
    """Counts, over many steps from one state: cells grown, pairs of cells grown together, and where agents 0 and 1 are and look."""
    env = environment(GAME, variant)
    sizes = env.module.FRAME[0] * env.module.FRAME[1]

    def look(before: Any, after: Any, _: Any) -> Any:
        grown = (before.soil_fruit == 0) & (after.soil_fruit == 1)
        return {
            "grown": grown,
            "together": grown & jnp.roll(grown, 1),
            "place": jax.nn.one_hot(after.position[:3], sizes, dtype=jnp.int32),
            "heading": jax.nn.one_hot(after.heading[:2], 4, dtype=jnp.int32),
        }

    return many(env, look)


@pytest.fixture(scope="module")
def counted() -> Any:
    return counter(None)


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
        grown = counter(variant)(
            seed, state_with(SOUTH, fruit=fruit, variant=variant), [6] * 7, env.params, 15
        )["grown"]
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


@pytest.mark.thorough
def test_growth_in_a_full_patch(counted: Any) -> None:
    """One cell picked from the full map at a time: 3 to 12 apples near, in corners, at edges and in the middle, all alike."""
    env = environment(GAME)
    cells = cells_of(env, "soil")
    for seed, cell in enumerate([(0, 0), (0, 21), (2, 7), (7, 21), (9, 2)]):
        fruit = np.ones(64, bool)
        fruit[cells.index(cell)] = False
        assert near(cells, fruit)[cells.index(cell)] >= 3
        grown = counted(seed, state_with(SOUTH, fruit=fruit), [6] * 7, env.params, 20)["grown"]
        assert_share(grown[cells.index(cell)], 20 * BATCH, 0.025, 0.13)


def test_cells_grow_independently(counted: Any) -> None:
    """Neighbours in the numbering, each with half a chance: both in a quarter of the steps (a mean of pairs is as tight at least as one)."""
    env = environment(GAME)
    cells = cells_of(env, "soil")
    fruit = np.zeros(64, bool)
    fruit[::3] = True
    half = env.params.replace(
        regrow_1=jnp.float32(0.5), regrow_2=jnp.float32(0.5), regrow_3=jnp.float32(0.5)
    )
    seen = counted(0, state_with(SOUTH, fruit=fruit), [6] * 7, half, 4)
    can = ~fruit & (near(cells, fruit) > 0)
    pairs = can & np.roll(can, 1)
    assert pairs.sum() > 15
    assert_share(seen["together"][pairs].sum() / pairs.sum(), 4 * BATCH, 0.25, 0.08)
    for site in np.flatnonzero(can):
        assert_share(seen["grown"][site], 4 * BATCH, 0.5, 0.05)


@pytest.mark.parametrize("variant", [None, "socialjax"])
def test_home_is_every_free_gate_alike(variant: str | None) -> None:
    """Two hit in every step: each comes to any of the 58 gates without an agent, and looks any way."""
    env = environment(GAME, variant)
    gates = cells_of(env, "gate")
    assert len(gates) == 60
    places = [(10, 5), (10, 6), (9, 5), (13, 5), (15, 10), (0, 10), (0, 11)]
    seen = counter(variant)(
        8,
        state_with(places, [1, 0, 0, 0, 0, 0, 0], variant=variant),
        [7, 6, 6, 6, 6, 6, 6],
        env.params,
        30,
    )
    free = [gate for gate in gates if gate not in places]
    assert len(free) == 58
    assert seen["place"][0, frame_cells(env, (10, 5))] == 30 * BATCH
    homes = seen["place"][1, frame_cells(env, free)]
    assert homes.sum() == 30 * BATCH
    assert_uniform(homes, 0.15)
    assert_uniform(seen["heading"][1], 0.03)
    assert seen["heading"][0].tolist() == [0, 30 * BATCH, 0, 0]


@pytest.mark.thorough
def test_who_was_away_comes_to_every_free_gate_alike() -> None:
    """As in Melting Pot, two who were hit come back in one step: each to any gate without an agent, no two to one, looking any way."""
    env = environment(GAME, "meltingpot")
    places = [(10, 5), (9, 5), (10, 6), (13, 5), (15, 10), (0, 10), (0, 11)]
    state = state_with(places, [0, 0, 0, 0, 0, 0, 0], variant="meltingpot")
    _, state, *_ = env.step_env(jax.random.key(0), state, jnp.array([7, 6, 6, 6, 6, 6, 6]))
    state = state.replace(
        heading=state.heading.at[0].set(1), agent_cooling=jnp.zeros_like(state.agent_cooling)
    )
    _, state, *_ = env.step_env(jax.random.key(1), state, jnp.array([7, 6, 6, 6, 6, 6, 6]))
    assert (state.away > 0).tolist() == [False, True, True, False, False, False, False]
    state = state.replace(away=jnp.minimum(state.away, 1))
    seen = counter("meltingpot")(9, state, [6] * 7, env.params, 30)
    free = [gate for gate in cells_of(env, "gate") if gate not in places]
    assert len(free) == 58
    for agent in (1, 2):
        homes = seen["place"][agent, frame_cells(env, free)]
        assert homes.sum() == 30 * BATCH
        assert_uniform(homes, 0.15)
    assert_uniform(seen["heading"][1], 0.03)
