"""The chances of Clean Up, counted: growth at each measure of dirt, and new dirt."""

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
        heading=jnp.zeros(7, jnp.int32),
    )


@cache
def counter(variant: str | None) -> Any:
    """Counts cells grown and cells newly dirty over many steps from one state."""

    def look(before: Any, after: Any, _: Any) -> Any:
        grown = after.orchard_fruit == 1
        dirtied = (before.water_state == 0) & (after.water_state == 1)
        return {
            "grown": grown,
            "dirtied": dirtied,
            "some": jnp.any(dirtied),
            "more": jnp.sum(dirtied, dtype=jnp.int32) > 1,
        }

    return many(environment("clean_up", variant), look)


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
def test_new_dirt_in_half_of_the_steps_from_the_fiftieth_on() -> None:
    """Never more than one cell; not before 50 steps are over."""
    env = environment("clean_up")
    counted = counter(None)
    for step in (0, 49):
        assert counted(step, state_with(79, step=step), STAYS, env.params, 4)["some"] == 0
    for step in (50, 51, 500):
        seen = counted(step, state_with(79, step=step), STAYS, env.params, 12)
        assert seen["more"] == 0
        assert_share(seen["some"], 12 * BATCH, 0.5, 0.03)
    assert counted(9, state_with(WATER, step=50), STAYS, env.params, 4)["some"] == 0


@pytest.mark.thorough
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
