"""The chances of Clean Up, counted: growth at each measure of dirt, new dirt and where, homes."""

from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from .chance import BATCH, assert_share, assert_uniform, many
from .environments import cells_of, environment, frame_cells

pytestmark = pytest.mark.optimised

WATER, RIVER, ORCHARD = 147, 167, 122  # cells. Source: the released code's map
STAYS = [6] * 7
SAND = [(9, c) for c in range(4, 8)] + [(8, c) for c in range(4, 7)]  # where nothing happens


def state_with(
    dirty: int | np.ndarray,
    places: Any = SAND,
    headings: Any = (0,) * 7,
    step: int = 0,
    variant: str | None = None,
) -> Any:
    """Returns a state with the first so many cells of water dirty, or those of a mask."""
    env = environment("clean_up", variant)
    _, state = env.reset(jax.random.key(0))
    mask = np.arange(WATER) < dirty if isinstance(dirty, int) else dirty
    return state.replace(
        step=jnp.int32(step),
        water_state=jnp.asarray(mask, jnp.uint8),
        position=jnp.asarray(frame_cells(env, list(places))),
        heading=jnp.array(headings, jnp.int32),
    )


@cache
def counter(variant: str | None) -> Any:
    """Counts, over many steps from one state: cells grown, cells newly dirty, both at once, and where agents 0 to 2 are and look."""
    env = environment("clean_up", variant)
    sizes = env.module.FRAME[0] * env.module.FRAME[1]

    def look(before: Any, after: Any, _: Any) -> Any:
        grown = after.orchard_fruit == 1
        dirtied = (before.water_state == 0) & (after.water_state == 1)
        return {
            "grown": grown,
            "dirtied": dirtied,
            "some": jnp.any(dirtied),
            "more": jnp.sum(dirtied, dtype=jnp.int32) > 1,
            "grown_when_dirtied": grown & jnp.any(dirtied),
            "twins": grown & dirtied[:ORCHARD],
            "last_twins": grown & dirtied[WATER - ORCHARD :],
            "place": jax.nn.one_hot(after.position[:3], sizes, dtype=jnp.int32),
            "heading": jax.nn.one_hot(after.heading[:2], 4, dtype=jnp.int32),
        }

    return many(env, look)


@pytest.fixture(scope="module")
def counted() -> Any:
    return counter(None)


# dirty cells -> growth of each orchard cell in a step, rounds. 0.05 (1 - f / 0.4), f of 167. Source: the released code's figures
GROWTH = [
    (0, 0.05, 1),
    (33, 0.0253, 2),
    (66, 5.988e-4, 12),
    (67, 0, 12),
    (79, 0, 2),
    (100, 0, 2),
    (147, 0, 2),
]
# f of 147. Source: Melting Pot's figures
WITHOUT_CHANNEL = [(0, 0.05, 1), (29, 0.02534, 2), (58, 6.803e-4, 12), (59, 0, 12), (79, 0, 2)]


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("variant", "dirty", "chance", "rounds"),
    [(None, *row) for row in GROWTH]
    + [("socialjax", *GROWTH[1])]
    + [("meltingpot", *row) for row in WITHOUT_CHANNEL],
)
def test_growth_falls_with_dirt(
    variant: str | None, dirty: int, chance: float, rounds: int
) -> None:
    """In Melting Pot the cells of the channel do not count."""
    env = environment("clean_up", variant)
    grown = counter(variant)(dirty, state_with(dirty, variant=variant), STAYS, env.params, rounds)[
        "grown"
    ]
    exact = 0.05 * max(0.0, 1 - dirty / (WATER if variant == "meltingpot" else RIVER) / 0.4)
    assert chance == pytest.approx(exact, rel=2e-3)
    if chance == 0:
        assert grown.sum() == 0
    else:
        assert_share(grown.sum(), ORCHARD * rounds * BATCH, exact, 0.1)


@pytest.mark.thorough
def test_every_orchard_cell_grows_alike(counted: Any) -> None:
    env = environment("clean_up")
    params = env.params.replace(best_rate=jnp.float32(0.5))
    for site in counted(1, state_with(0), STAYS, params, 4)["grown"]:
        assert_share(site, 4 * BATCH, 0.5, 0.05)


def test_new_dirt_in_half_of_the_steps_from_the_fiftieth_on(counted: Any) -> None:
    """Never more than one cell; not before 50 steps are over."""
    env = environment("clean_up")
    for step in (0, 49):
        assert counted(step, state_with(79, step=step), STAYS, env.params, 4)["some"] == 0
    for step in (50, 51, 500):
        seen = counted(step, state_with(79, step=step), STAYS, env.params, 12)
        assert seen["more"] == 0
        assert_share(seen["some"], 12 * BATCH, 0.5, 0.03)
    assert counted(9, state_with(WATER, step=50), STAYS, env.params, 4)["some"] == 0


def test_dirt_comes_to_every_clean_cell_alike(counted: Any) -> None:
    """Covered or not: of 49 clean cells seven are under agents."""
    env = environment("clean_up")
    water = cells_of(env, "water")
    clean = np.arange(WATER) % 3 == 1
    places = [water[i] for i in np.flatnonzero(clean)[[0, 7, 8, 20, 30, 40, 48]]]
    seen = counted(
        2,
        state_with(~clean, places, step=60),
        STAYS,
        env.params.replace(pollution=jnp.float32(1)),
        24,
    )
    assert seen["some"] == 24 * BATCH
    assert seen["dirtied"][~clean].sum() == 0
    assert_uniform(seen["dirtied"][clean], 0.15)


def test_as_released_dirt_waits_a_step_more_and_is_lost_on_covered_cells() -> None:
    """Of 49 clean cells seven are under agents: where one of them is drawn, none turns dirty. Source: the released code."""
    env = environment("clean_up", "socialjax")
    water = cells_of(env, "water")
    clean = np.arange(WATER) % 3 == 1
    covered = np.flatnonzero(clean)[[0, 7, 8, 20, 30, 40, 48]]
    sure = env.params.replace(pollution=jnp.float32(1))
    places = [water[i] for i in covered]
    first = counter("socialjax")(
        0, state_with(~clean, places, step=50, variant="socialjax"), STAYS, sure, 2
    )
    assert first["some"] == 0
    seen = counter("socialjax")(
        2, state_with(~clean, places, step=51, variant="socialjax"), STAYS, sure, 24
    )
    assert_share(seen["some"], 24 * BATCH, 42 / 49, 0.02)
    bare = np.setdiff1d(np.flatnonzero(clean), covered)
    assert seen["dirtied"].sum() == seen["dirtied"][bare].sum() == seen["some"]
    assert_uniform(seen["dirtied"][bare], 0.15)


def test_dirt_and_growth_are_independent(counted: Any) -> None:
    """Whether dirt comes tells nothing about any orchard cell, and where it comes tells nothing about the cell of the same number."""
    env = environment("clean_up")
    half = env.params.replace(best_rate=jnp.float32(0.5))
    seen = counted(3, state_with(0, step=50), STAYS, half, 8)
    for site in seen["grown_when_dirtied"]:
        assert_share(site, 8 * BATCH, 0.25, 0.06)
    seen = counted(4, state_with(0, step=50), STAYS, half.replace(pollution=jnp.float32(1)), 24)
    assert_share(seen["twins"].sum(), 24 * BATCH, 0.5 * ORCHARD / WATER, 0.03)
    assert_share(seen["last_twins"].sum(), 24 * BATCH, 0.5 * ORCHARD / WATER, 0.03)


@pytest.mark.parametrize("variant", [None, "socialjax"])
def test_home_is_every_free_gate_alike(variant: str | None) -> None:
    """17 of the 19 gates: on one stands the zapper, on another an idle agent; the one who is hit stands on a third."""
    env = environment("clean_up", variant)
    gates = cells_of(env, "gate")
    places = [(11, 17), (11, 16), (6, 3), (12, 1), (12, 2), (12, 3), (12, 4)]
    seen = counter(variant)(
        5,
        state_with(0, places, [3, 0, 0, 0, 0, 0, 0], variant=variant),
        [7, *STAYS[1:]],
        env.params,
        16,
    )
    homes = seen["place"][1, frame_cells(env, [gate for gate in gates if gate not in places])]
    assert (len(homes), homes.sum()) == (17, 16 * BATCH)
    assert_uniform(homes, 0.1)
    assert_uniform(seen["heading"][1], 0.04)


@pytest.mark.thorough
def test_who_was_away_comes_to_every_free_gate_alike() -> None:
    """As in Melting Pot, some time after the hit: on two of the 19 gates stand others."""
    env = environment("clean_up", "meltingpot")
    gates = cells_of(env, "gate")
    places = [(12, 18), (12, 17), (7, 4), (13, 2), (13, 3), (13, 4), (13, 5)]
    state = state_with(0, places, [3, 0, 0, 0, 0, 0, 0], variant="meltingpot")
    _, state, *_ = env.step_env(jax.random.key(0), state, jnp.array([7, *STAYS[1:]]))
    assert state.away.tolist() == [0, 50, 0, 0, 0, 0, 0]
    state = state.replace(away=jnp.minimum(state.away, 1))
    seen = counter("meltingpot")(6, state, STAYS, env.params, 12)
    homes = seen["place"][1, frame_cells(env, [gate for gate in gates if gate not in places])]
    assert (len(homes), homes.sum()) == (17, 12 * BATCH)
    assert_uniform(homes, 0.12)
    assert_uniform(seen["heading"][1], 0.05)


@pytest.mark.parametrize("variant", [None, "socialjax"])
@pytest.mark.parametrize("number", [2, 3])
def test_a_cell_that_several_clean_counts_once_and_for_each_alike(
    number: int, variant: str | None
) -> None:
    env = environment("clean_up", variant)
    dirty = np.array([cell == (4, 2) for cell in cells_of(env, "water")])
    state = state_with(dirty, [(5, 1), (5, 3), (5, 2), *SAND[3:]], variant=variant)

    def cleaned(key: jax.Array) -> jax.Array:
        return env.step_env(key, state, jnp.array([8] * number + [6] * (7 - number)))[4]["events"][
            "cleaned"
        ]

    found = np.asarray(jax.jit(jax.vmap(cleaned))(jax.random.split(jax.random.key(9), BATCH)))
    assert (found.sum(axis=1) == 1).all()
    assert found[:, number:].sum() == 0
    assert_uniform(found[:, :number].sum(axis=0), 0.13)
