"""The chances of Coins, counted: how often coins come, where, of which colour."""

from functools import cache
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest

from .chance import BATCH, assert_share, assert_uniform, many
from .environments import cells_of, environment, placed

pytestmark = pytest.mark.optimised

STAY = 6


@cache
def counter(variant: str | None) -> Any:
    """Counts, over many steps from one state: red and green coins by cell, and coins on cells of two numbers in a row."""
    env = environment("coins", variant)

    def look(_: Any, after: Any, __: Any) -> Any:
        red, green = after.tile_coin == 1, after.tile_coin == 2
        return {
            "red": red,
            "green": green,
            "both": (red | green) & jnp.roll(red | green, 1),
            "same": (red & jnp.roll(red, 1)) | (green & jnp.roll(green, 1)),
        }

    return many(env, look)


@pytest.fixture(scope="module")
def counted() -> Any:
    return counter(None)


CORNERS = [(1, 1), (14, 9)]


@pytest.mark.parametrize(
    ("variant", "colour"),
    [(None, 0.0005), pytest.param("meltingpot", 0.00025, marks=pytest.mark.thorough)],
)
def test_coins_come_so_often(variant: str | None, colour: float) -> None:
    """Of each colour. Sources: the paper (the released code's sum is 0.00099975); Melting Pot's 0.0005 is for both colours together."""
    env = environment("coins", variant)
    steps = 20 * BATCH
    corners = cells_of(env, "corner")
    assert corners == (CORNERS if variant is None else [(1, 11), (10, 1)])
    seen = counter(variant)(0, placed(env, corners), [STAY, STAY], env.params, 20)
    cells = (174 if variant is None else 154) * steps
    within = 0.06 if variant is None else 0.09
    assert_share(seen["red"].sum() + seen["green"].sum(), cells, 2 * colour, within)
    assert_share(seen["red"].sum(), cells, colour, 1.4 * within)
    assert_share(seen["green"].sum(), cells, colour, 1.4 * within)


def test_cells_and_colours_are_alike(counted: Any) -> None:
    """At a hundred times the rate: every cell, both colours, neighbours in the numbering independent in both."""
    env = environment("coins")
    steps = 16 * BATCH
    seen = counted(
        1, placed(env, CORNERS), [STAY, STAY], env.params.replace(spawn=jnp.float32(0.05)), 16
    )
    for site in range(174):
        assert_share(seen["red"][site], steps, 0.05, 0.1)
        assert_share(seen["green"][site], steps, 0.05, 0.1)
    assert_share(seen["both"].sum() / 174, steps, 0.01, 0.25)
    assert_share(seen["same"].sum() / 174, steps, 0.005, 0.35)
    colours = np.array([seen["red"].sum(), seen["green"].sum()])
    assert_uniform(colours, 0.01)
