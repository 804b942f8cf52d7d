"""What Melting Pot's variants draw, counted on the interpreter: how episodes end, who shares gold, which mushrooms die. Source: Melting Pot."""

from collections import Counter

import pytest

from sjdsl.testing import Stage

from .chance import assert_share, assert_uniform

RUNS = 300
FIELD = ("A.......", "........", "QQPPPPPP")
STAGES = {
    "coins": ("CCCC", "PCCP"),
    "clean_up": ("HHHH", "SSSS", "B.PP"),
    "harvest_open": FIELD,
    "harvest_closed": FIELD,
    "harvest_partnership": FIELD,
    "coop_mining": ("OOOO", "OOPP"),
    "gift_refinement": ("TTTT", "TTPP"),
    "mushrooms": ("....", "...."),
}
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
@pytest.mark.parametrize("game", STAGES)
def test_an_episode_ends_by_chance_after_whole_intervals(game: str) -> None:
    """First 99 steps after the least length, as there, and in no step between; it is terminated, not truncated."""
    stage = Stage(game, STAGES[game], 2, variant="meltingpot", interpreted=True)
    least = 300 if game == "coins" else 1000
    start = stage.start()

    def ends(finished: int, seed: int, chance: float) -> bool:
        start.change(ending=chance)
        start.seed, start.world.step = seed, finished - 1
        world = start.world
        start.step()
        start.world, done = world, start.terminated
        assert not start.truncated
        return done

    for finished, wanted in (
        (least - 1, False),
        (least, False),
        (least + 99, True),
        (least + 100, False),
        (least + 399, True),
    ):
        assert ends(finished, 0, 1.0) is wanted
        assert not ends(finished, 0, 0.0)
    assert_share(sum(ends(least + 99, seed, 0.5) for seed in range(RUNS)), RUNS, 0.5, 0.4)


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
