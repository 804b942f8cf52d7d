"""The chances of Gift Refinement, counted: how often tokens come, and where; contested cells."""

from typing import Any

import jax.numpy as jnp
import pytest

from .chance import BATCH, assert_share, many
from .environments import cells_of, environment, frame_cells, placed

pytestmark = pytest.mark.optimised

GAME = "gift_refinement"
GROUND = 538  # cells. Source: the released code's map
STAY, FORWARD = 6, 4
OPEN = (15, 12)  # a cell of ground with ground around it


@pytest.fixture(scope="module")
def counted() -> Any:
    """Counts, over many steps from one state: new tokens by cell, neighbours in the numbering, tokens that stay, winners of a cell, bags."""
    env = environment(GAME)
    contested = int(frame_cells(env, OPEN))

    def look(before: Any, after: Any, _: Any) -> Any:
        new = (before.ground_token == 0) & (after.ground_token == 1)
        return {
            "new": new,
            "both": new & jnp.roll(new, 1),
            "kept": (before.ground_token == 1) & (after.ground_token == 1),
            "won": after.position == contested,
            "bags": after.agent_bag,
        }

    return many(env, look)


def often(spawn: float) -> Any:
    """Returns the parameters with another chance of a token."""
    return environment(GAME).params.replace(spawn=jnp.float32(spawn))


def test_a_token_in_five_thousand_cells_and_steps(counted: Any) -> None:
    """0.0002 of each empty cell. Sources: the paper; the released code."""
    env = environment(GAME)
    seen = counted(0, placed(env, cells_of(env, "camp")[:5]), [STAY] * 5, env.params, 20)
    assert seen["new"].size == GROUND
    assert_share(seen["new"].sum(), GROUND * 20 * BATCH, 0.0002, 0.06)
