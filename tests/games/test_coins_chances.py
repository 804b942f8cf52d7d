"""The chances of Coins, counted: how often coins come, where, of which colour; contested cells."""

from functools import cache
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from .chance import BATCH, assert_share, assert_uniform, many
from .environments import cells_of, environment, frame_cells

pytestmark = pytest.mark.optimised

STAY = 6


def state_with(places: list[tuple[int, int]], headings: tuple[int, int] = (0, 0), coin: Any = None, variant: str | None = None) -> Any:
    env = environment("coins", variant)
    _, state = env.reset(jax.random.key(0))
    changed = {} if coin is None else {"tile_coin": jnp.asarray(coin, jnp.uint8)}
    return state.replace(position=jnp.asarray(frame_cells(env, places)), heading=jnp.array(headings, jnp.int32), **changed)


@cache
def counter(variant: str | None) -> Any:
    """Counts, over many steps from one state: red and green coins by cell, coins on cells of two numbers in a row, and winners of (5, 5)."""
    env = environment("coins", variant)

    def look(_: Any, after: Any, reward: Any) -> Any:
        red, green = after.tile_coin == 1, after.tile_coin == 2
        return {
            "red": red,
            "green": green,
            "both": (red | green) & jnp.roll(red | green, 1),
            "same": (red & jnp.roll(red, 1)) | (green & jnp.roll(green, 1)),
            "won": after.position == int(frame_cells(env, (5, 5))),
            "reward": reward,
        }

    return many(env, look)


@pytest.fixture(scope="module")
def counted() -> Any:
    return counter(None)


CORNERS = [(1, 1), (14, 9)]


@pytest.mark.parametrize(("variant", "colour"), [(None, 0.0005), pytest.param("meltingpot", 0.00025, marks=pytest.mark.thorough)])
def test_coins_come_so_often(variant: str | None, colour: float) -> None:
    """Of each colour. Sources: the paper (the released code's sum is 0.00099975); Melting Pot's 0.0005 is for both colours together."""
    env = environment("coins", variant)
    steps = 20 * BATCH
    corners = cells_of(env, "corner")
    assert corners == (CORNERS if variant is None else [(1, 11), (10, 1)])
    seen = counter(variant)(0, state_with(corners, variant=variant), [STAY, STAY], env.params, 20)
    cells = (174 if variant is None else 154) * steps
    within = 0.06 if variant is None else 0.09
    assert_share(seen["red"].sum() + seen["green"].sum(), cells, 2 * colour, within)
    assert_share(seen["red"].sum(), cells, colour, 1.4 * within)
    assert_share(seen["green"].sum(), cells, colour, 1.4 * within)


def test_cells_and_colours_are_alike(counted: Any) -> None:
    """At a hundred times the rate: every cell, both colours, neighbours in the numbering independent in both."""
    env = environment("coins")
    steps = 16 * BATCH
    seen = counted(1, state_with(CORNERS), [STAY, STAY], env.params.replace(spawn=jnp.float32(0.05)), 16)
    for site in range(174):
        assert_share(seen["red"][site], steps, 0.05, 0.1)
        assert_share(seen["green"][site], steps, 0.05, 0.1)
    assert_share(seen["both"].sum() / 174, steps, 0.01, 0.25)
    assert_share(seen["same"].sum() / 174, steps, 0.005, 0.35)
    colours = np.array([seen["red"].sum(), seen["green"].sum()])
    assert_uniform(colours, 0.01)


def test_cells_with_coins_or_agents_have_no_chance(counted: Any) -> None:
    """At the highest rate everything else is full after a step, half of it green."""
    env = environment("coins")
    places = [(3, 3), (8, 4)]
    coin = np.zeros(174, int)
    coin[40:60], coin[60:80] = 1, 2
    steps = 4 * BATCH
    seen = counted(2, state_with(places, coin=coin), [STAY, STAY], env.params.replace(spawn=jnp.float32(0.5)), 4)
    under = [cells_of(env, "tile").index(place) for place in places]
    assert not (set(under) & set(range(40, 80)))
    total = seen["red"] + seen["green"]
    assert total[under].tolist() == seen["reward"].tolist() == [0, 0]
    assert (np.delete(total, under) == steps).all()
    assert (seen["red"][40:60] == steps).all()
    assert (seen["green"][60:80] == steps).all()
    fresh = [site for site in range(174) if coin[site] == 0 and site not in under]
    assert_uniform([seen["red"][fresh].sum(), seen["green"][fresh].sum()], 0.01)


def test_a_contested_cell_goes_to_each_alike(counted: Any) -> None:
    env = environment("coins")
    seen = counted(3, state_with([(5, 4), (6, 5)], (1, 0)), [4, 4], env.params, 16)
    assert seen["won"].sum() == 16 * BATCH
    assert_uniform(seen["won"], 0.03)
