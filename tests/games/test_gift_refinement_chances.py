"""The chances of Gift Refinement, counted: how often tokens come, and where; contested cells."""

from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest

from .chance import BATCH, assert_share, assert_uniform, many
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


def test_cells_are_alike(counted: Any) -> None:
    """At a high rate: every cell, and neighbours in the numbering independent."""
    env = environment(GAME)
    seen = counted(1, placed(env, cells_of(env, "camp")[:5]), [STAY] * 5, often(0.5), 2)
    for site in range(GROUND):
        assert_share(seen["new"][site], 2 * BATCH, 0.5, 0.07)
    assert_share(seen["both"].sum() / GROUND, 2 * BATCH, 0.25, 0.13)


def test_cells_with_tokens_or_agents_have_no_chance(counted: Any) -> None:
    """At the highest rate all other cells are full after a step; camps and the five cells of agents are not."""
    env = environment(GAME)
    ground, under = cells_of(env, "ground"), [0, 7, 99, 250, 537]
    token = np.isin(np.arange(GROUND), range(100, 120))
    seen = counted(2, placed(env, [ground[i] for i in under], 2, ground_token=token), [STAY] * 5, often(1), 2)
    assert (seen["kept"] == token * 2 * BATCH).all()
    fresh = [i for i in range(GROUND) if not token[i] and i not in under]
    assert (seen["new"][fresh] == 2 * BATCH).all()
    assert not seen["new"][under].any()
    assert not seen["bags"].any()


def test_tokens_grow_first(counted: Any) -> None:
    """Before agents move: the cell one leaves in this step has no chance in it, the one it comes to has, and is emptied."""
    env = environment(GAME)
    ground, (row, col) = cells_of(env, "ground"), OPEN
    state = placed(env, [OPEN, *cells_of(env, "camp")[:4]])
    seen = counted(3, state, [FORWARD, STAY, STAY, STAY, STAY], often(1), 1)
    assert seen["new"][ground.index(OPEN)] == 0
    assert seen["new"][ground.index((row - 1, col))] == 0
    assert seen["new"].sum() == (GROUND - 2) * BATCH


def test_a_contested_cell_goes_to_each_alike(counted: Any) -> None:
    """Three want it; then two."""
    env = environment(GAME)
    row, col = OPEN
    state = placed(env, [(row, col - 1), (row + 1, col), (row, col + 1), *cells_of(env, "camp")[:2]], [1, 0, 3, 0, 0])
    for number in (3, 2):
        won = counted(7, state, [FORWARD] * number + [STAY] * (5 - number), env.params, 8)["won"]
        assert won.sum() == 8 * BATCH
        assert_uniform(won[:number], 0.05)
