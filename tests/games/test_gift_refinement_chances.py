"""The chances of Gift Refinement, counted: how often tokens come, and where."""

from functools import cache
from typing import Any

import jax.numpy as jnp
import pytest

from .chance import BATCH, assert_share, many
from .environments import cells_of, environment, placed

pytestmark = pytest.mark.optimised

GAME = "gift_refinement"
GROUND = 538  # cells. Source: the released code's map
STAY = 6


@cache
def counter(variant: str | None) -> Any:
    """Counts, over many steps from one state: new tokens by cell, and neighbours in the numbering."""
    env = environment(GAME, variant)

    def look(before: Any, after: Any, _: Any) -> Any:
        new = (before.ground_token == 0) & (after.ground_token == 1)
        return {"new": new, "both": new & jnp.roll(new, 1)}

    return many(env, look)


@pytest.fixture(scope="module")
def counted() -> Any:
    return counter(None)


def often(spawn: float) -> Any:
    """Returns the parameters with another chance of a token."""
    return environment(GAME).params.replace(spawn=jnp.float32(spawn))


@pytest.mark.parametrize("variant", [None, "socialjax"])
def test_a_token_in_five_thousand_cells_and_steps(variant: str | None) -> None:
    """0.0002 of each empty cell. Sources: the paper; the released code."""
    env = environment(GAME, variant)
    seen = counter(variant)(0, placed(env, cells_of(env, "camp")[:5]), [STAY] * 5, env.params, 20)
    assert seen["new"].size == GROUND
    assert_share(seen["new"].sum(), GROUND * 20 * BATCH, 0.0002, 0.06)


def test_cells_are_alike(counted: Any) -> None:
    """At a high rate: every cell, and neighbours in the numbering independent."""
    env = environment(GAME)
    seen = counted(1, placed(env, cells_of(env, "camp")[:5]), [STAY] * 5, often(0.5), 2)
    for site in range(GROUND):
        assert_share(seen["new"][site], 2 * BATCH, 0.5, 0.07)
    assert_share(seen["both"].sum() / GROUND, 2 * BATCH, 0.25, 0.13)
