"""How often coins, tokens, ore and resources come by themselves, counted over many steps of the compiled games."""

from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest

from .chance import BATCH, assert_share, many
from .environments import cells_of, environment, placed

pytestmark = [pytest.mark.optimised, pytest.mark.thorough]

STAY = 6
# Game, variant, the kind that agents stand on, the field that is filled, and the chance of each of its values
# in a step and an empty cell. Sources: the paper; the released code; Melting Pot.
RATES = [
    ("coins", None, "corner", "tile_coin", (0.0005, 0.0005)),
    ("coins", "meltingpot", "corner", "tile_coin", (0.00025, 0.00025)),
    ("gift_refinement", None, "camp", "ground_token", (0.0002,)),
    ("gift_refinement", "socialjax", "camp", "ground_token", (0.0002,)),
    ("coop_mining", None, "camp", "rock_ore", (0.0004, 0.9996 * 0.00016)),
    ("coop_mining", "socialjax", "camp", "rock_ore", (0.0002, 0.9998 * 0.00008)),
    ("coop_mining", "meltingpot", "camp", "rock_ore", (0.0002, 0.9998 * 0.00008)),
    ("pd_arena", None, "gate", "patch_stock", (0.1,)),
    ("pd_arena", "socialjax", "gate", "patch_stock", (0.1,)),
]


@pytest.mark.parametrize(("game", "variant", "home", "field", "chances"), RATES)
def test_rate(game: str, variant: str | None, home: str, field: str, chances: Any) -> None:
    env = environment(game, variant)
    homes = cells_of(env, home)[: env.num_agents]
    state = placed(env, homes)
    state = state.replace(**{field: jnp.zeros_like(getattr(state, field))})

    def look(_: Any, after: Any, __: Any) -> Any:
        return [getattr(after, field) == value for value in range(1, len(chances) + 1)]

    rounds = 24
    seen = many(env, look)(0, state, [STAY] * env.num_agents, env.params, rounds)
    for cells, chance in zip(seen, chances, strict=True):
        assert_share(np.sum(cells), cells.size * rounds * BATCH, chance, within=0.13)
