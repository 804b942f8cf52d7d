"""What Melting Pot's variants draw, counted on the interpreter: how episodes end, who shares gold, which mushrooms die. Source: Melting Pot."""

from collections import Counter

import pytest

from sjdsl.testing import Stage

from .chance import assert_share, assert_uniform

RUNS = 300
MINE = Stage(
    "coop_mining",
    ("OOOOO", "OOOOO", "PPPPP"),
    3,
    variant="meltingpot",
    looks={"g": "rock ore=gold"},
    interpreted=True,
)
FOREST = Stage("mushrooms", ("........", "........"), 2, variant="meltingpot", interpreted=True)


@pytest.mark.thorough
def test_of_three_miners_two_share() -> None:
    """Who comes third gets nothing, and the ore is gone; each of the three is left out equally often."""
    left_out: Counter[int] = Counter()
    for seed in range(RUNS):
        scene = MINE.put(
            "O>g<O", "OO^OO", "PPPPP", seed=seed, params={"spawn_iron": 0.0, "spawn_gold": 0.0}
        ).step("mine, mine, mine")
        assert sorted(scene.reward) == [0, 8, 8]
        assert scene.value("rock.ore")[2] == "none"
        left_out[scene.reward.index(0)] += 1
    assert_uniform([left_out[agent] for agent in range(3)], 0.6)


def test_orange_kills_each_red_one_alike() -> None:
    """And nothing else: with the chance that is set, each red mushroom dies. The orange one grows again somewhere."""
    gone = 0
    for seed in range(RUNS // 3):
        scene = FOREST.put(
            "O.RRRRRG",
            "^......v  01",
            seed=seed,
            params={"poison": 0.5},
            fields={"ground.fresh": 9},
        ).step("forward")
        reds = scene.value("ground.grows")[2:7].count("red")
        assert scene.value("ground.grows").count("orange") == 1
        assert scene.value("ground.grows")[7] == "green"
        gone += 5 - reds
    assert_share(gone, 5 * (RUNS // 3), 0.5, 0.3)
