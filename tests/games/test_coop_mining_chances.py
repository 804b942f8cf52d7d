"""The chances of Coop Mining, counted: where iron and gold come and how often, who gets a contested ore."""

from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest

from .chance import BATCH, assert_share, assert_uniform, many
from .environments import cells_of, environment, placed

pytestmark = pytest.mark.optimised

ROCK = 538  # cells. Source: the released code's map
NONE, IRON, GOLD = range(3)
MINE, STAY = 7, 6
OPEN = (16, 13)  # a cell of rock with rock around it
# chance of iron, and of gold where no iron came. Sources: the paper; the released code; Melting Pot
RATES = {None: (0.0004, 0.00016), "socialjax": (0.0002, 0.00008), "meltingpot": (0.0002, 0.00008)}


def counter(variant: str | None) -> Any:
    """Counts, over many steps from one state: iron and gold by cell, and neighbours in the numbering."""
    env = environment("coop_mining", variant)

    def look(before: Any, after: Any, _: Any) -> Any:
        iron = (before.rock_ore == NONE) & (after.rock_ore == IRON)
        gold = (before.rock_ore == NONE) & (after.rock_ore == GOLD)
        return {
            "iron": iron,
            "gold": gold,
            "irons": iron & jnp.roll(iron, 1),
            "both": (iron | gold) & jnp.roll(iron | gold, 1),
        }

    return many(env, look)


@pytest.fixture(scope="module")
def counted() -> Any:
    return counter(None)


def camped(**changed: Any) -> Any:
    """Returns a state with all agents in camps, where nothing grows."""
    env = environment("coop_mining", None)
    return placed(env, cells_of(env, "camp")[:6], **changed)


def raised(iron: float, gold: float) -> Any:
    """Returns the parameters with other chances of growth."""
    return environment("coop_mining", None).params.replace(
        spawn_iron=jnp.float32(iron), spawn_gold=jnp.float32(gold)
    )


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("variant", "rounds", "within"),
    [
        (None, 24, 0.06),
        *(
            pytest.param(variant, 12, 0.12, marks=pytest.mark.slow)
            for variant in ("socialjax", "meltingpot")
        ),
    ],
)
def test_iron_and_gold_come_so_often(
    variant: str | None, rounds: int, within: float, counted: Any
) -> None:
    """Of each cell and step without ore; half as often in the variants."""
    env, (iron, gold) = environment("coop_mining", variant), RATES[variant]
    run = counted if variant is None else counter(variant)
    seen = run(0, placed(env, cells_of(env, "camp")[:6]), [STAY] * 6, env.params, rounds)
    rocks = len(cells_of(env, "rock"))
    trials = rocks * rounds * BATCH
    assert seen["iron"].size == rocks
    assert_share(seen["iron"].sum(), trials, iron, within)
    assert_share(seen["gold"].sum(), trials, (1 - iron) * gold, within)


@pytest.mark.thorough
def test_gold_comes_only_where_no_iron_came_and_all_cells_are_alike(counted: Any) -> None:
    """Half of the cells get iron, half of the others gold; neighbours in the numbering tell nothing of each other."""
    seen = counted(1, camped(), [STAY] * 6, raised(0.5, 0.5), 2)
    for site in range(ROCK):
        assert_share(seen["iron"][site], 2 * BATCH, 0.5, 0.07)
        assert_share(seen["gold"][site], 2 * BATCH, 0.25, 0.13)
    assert_share(seen["irons"].sum() / ROCK, 2 * BATCH, 0.25, 0.13)
    assert_share(seen["both"].sum() / ROCK, 2 * BATCH, 0.5625, 0.07)
    seen = counted(2, camped(), [STAY] * 6, raised(0.25, 1), 2)
    assert (seen["iron"] + seen["gold"] == 2 * BATCH).all()
    assert_share(seen["gold"].sum() / ROCK, 2 * BATCH, 0.75, 0.05)


def test_contested_iron_goes_to_each_miner_alike() -> None:
    """Three hit one iron; then two pairs one each, and who wins the one tells nothing of the other."""
    env = environment("coop_mining", None)
    rock, camps = cells_of(env, "rock"), cells_of(env, "camp")
    row, col = OPEN
    run = many(
        env,
        lambda _, after, reward: (
            jnp.sum(after.rock_ore, dtype=jnp.int32),
            reward,
            jnp.outer(reward, reward),
        ),
    )
    irons = [rock.index((row, c)) for c in (col, col + 4)]
    one, two = (np.isin(np.arange(ROCK), found) * IRON for found in (irons[:1], irons))
    west, south, east = (row, col - 1), (row + 1, col), (row, col + 1)
    state = placed(env, [west, south, east, *camps[:3]], [1, 0, 3, 0, 0, 0], rock_ore=one)
    left, paid, _ = run(5, state, [MINE] * 3 + [STAY] * 3, raised(0, 0), 4)
    assert (left, paid[3:].sum(), paid.sum()) == (0, 0, 4 * BATCH)
    assert_uniform(paid[:3], 0.07)
    state = placed(
        env,
        [west, south, (row, col + 3), (row + 1, col + 4), *camps[:2]],
        [1, 0, 1, 0, 0, 0],
        rock_ore=two,
    )
    left, paid, pairs = run(6, state, [MINE] * 4 + [STAY] * 2, raised(0, 0), 4)
    assert (left, paid[4:].sum(), paid.sum()) == (0, 0, 8 * BATCH)
    assert_uniform(pairs[:2, 2:4].reshape(-1), 0.08)
