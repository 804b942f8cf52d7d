"""Coop Mining, scene by scene: what the ray hits, who is paid for iron and for gold, how long a gold ore waits, where ore grows."""

from typing import Any

import pytest

from sjdsl.testing import Scene, Stage

from .environments import stage_of

ROWS = ("OOOOOOO", "OOOOOOO", "OOOOOOO", "OOOOOOO", "OOOOOOO", "OOOOO#O", "OOOOOOO", "PPPPPPP")
EMPTY = "OOOOOOO"
LOOKS = {"i": "rock ore=iron", "g": "rock ore=gold", "p": "rock ore=partial"}
STAGES = {
    variant: stage_of(
        "coop_mining",
        ROWS,
        6,
        variant=variant,
        looks=LOOKS,
    )
    for variant in (None, "socialjax")
}
RELEASED = STAGES["socialjax"]
BOTH = pytest.mark.parametrize("stage", STAGES.values(), ids=["default", "socialjax"])
AROUND = ((-1, 0), (0, 1), (1, 0), (0, -1))
# six around the ore at (3, 3), each with a free ray, nearest first: (row, column, arrow)
MINERS = ((3, 2, ">"), (3, 4, "<"), (2, 3, "v"), (4, 3, "^"), (3, 1, ">"), (1, 3, "v"))


def put(
    stage: Stage,
    *picture: str,
    seed: int = 0,
    step: int = 0,
    under: dict[int, str] | None = None,
    **params: float,
) -> Scene:
    """Returns a scene in which no ore grows unless `params` say so; agents without a place in the picture stand in the camps."""
    return stage.put(
        *picture,
        seed=seed,
        step=step,
        under=under,
        params={"spawn_iron": 0, "spawn_gold": 0} | params,
    )


def placed(
    stage: Stage, poses: list[tuple[int, int, str]], ores: dict[tuple[int, int], str], **facts: Any
) -> Scene:
    """Returns a scene with agents 0, 1, … at these places; those left stand in the camps, facing south."""
    rest = [(7, column, "v") for column in range(6 - len(poses))]
    rows, beside = [list(row) for row in ROWS], [[] for _ in ROWS]
    for (row, column), sign in ores.items():
        rows[row][column] = sign
    for agent, (row, column, arrow) in enumerate([*poses, *rest]):
        rows[row][column] = arrow
        beside[row].append((column, agent))
    told = ["".join(str(agent) for _, agent in sorted(row)) for row in beside]
    return put(
        stage,
        *(
            "".join(row) + (f"  {numbers}" if numbers else "")
            for row, numbers in zip(rows, told, strict=True)
        ),
        **facts,
    )


def ores(scene: Scene) -> str:
    """Returns the states of all cells of rock that are not bare, in reading order."""
    return " ".join(ore for ore in scene.value("rock.ore") if ore != "none")


def around(number: int, stage: Stage, seed: int = 0, under: str = "g") -> Scene:
    """Returns a scene with so many miners around an ore at (3, 3)."""
    return placed(stage, list(MINERS[:number]), {(3, 3): under}, seed=seed)


def gold(stage: Stage, opener: int, completer: int) -> list[float]:
    """Returns what the six are paid for gold that these two have hit."""
    paid = {completer} if stage is RELEASED else {opener, completer}
    return [8 if agent in paid else 0 for agent in range(6)]


def counted(stage: Stage) -> list[int]:
    """Returns the counts of miners of gold that agent 1 completes after agent 0: as released, both for the one who is paid."""
    return [0, 2, 0, 0, 0, 0] if stage is RELEASED else [1, 1, 0, 0, 0, 0]


def mine(*agents: int) -> str:
    return ", ".join("mine" if agent in agents else "stay" for agent in range(6))


# The ray


@BOTH
@pytest.mark.parametrize("heading", range(4))
@pytest.mark.parametrize("distance", range(1, 5))
def test_iron_is_mined_up_to_three_cells_ahead(stage: Stage, heading: int, distance: int) -> None:
    row, column = (
        3 - 2 * AROUND[heading][0],
        3 - 2 * AROUND[heading][1],
    )  # two cells behind the middle
    ore = (row + distance * AROUND[heading][0], column + distance * AROUND[heading][1])
    scene = placed(stage, [(row, column, "^>v<"[heading])], {ore: "i"}).step("mine")
    assert ores(scene) == ("" if distance <= 3 else "iron")
    scene.has(
        {
            "reward": [int(distance <= 3), 0, 0, 0, 0, 0],
            "event iron_mined": [int(distance <= 3), 0, 0, 0, 0, 0],
        }
    )


@BOTH
@pytest.mark.parametrize("nearest", ["i", "g", "p"])
def test_the_ray_ends_at_the_first_ore(stage: Stage, nearest: str) -> None:
    scene = put(
        stage,
        EMPTY,
        "OOOiOOO",
        f"OOO{nearest}OOO",
        "OOO^OOO  0",
        EMPTY,
        "OOOOO#O",
        EMPTY,
        "vvvvvPP",
    ).step("mine")
    assert (
        ores(scene) == {"i": "iron", "g": "iron partial", "p": "iron gold"}[nearest]
    )  # a partial ore without time left closes
    scene.has({"event iron_mined": [int(nearest == "i"), 0, 0, 0, 0, 0]})


# Iron


@BOTH
@pytest.mark.parametrize(("miners", "runs"), [(2, 20), (6, 1)])
def test_contested_iron_goes_to_one_of_the_miners(stage: Stage, miners: int, runs: int) -> None:
    """Of two, each gets it in some run: else one of them has lost 20 times, a chance of 2e-6. As released it is the one with the lower number."""
    winners = set()
    for seed in range(runs):
        scene = around(miners, stage, seed, under="i").step(mine(*range(miners)))
        assert sorted(scene.reward) == [0] * 5 + [1]
        assert scene.events["iron_mined"] == scene.reward
        assert ores(scene) == ""
        winners.add(scene.reward.index(1))
    assert miners > 2 or winners == ({0} if stage is RELEASED else {0, 1})


# Gold

# miners in one step -> what each is paid, what becomes of the ore, what is counted
TOGETHER = [
    (1, 0, "partial", 0),
    (2, 8, "", 1),
    (3, 8, "", 1),
    (4, 8, "", 1),
    (5, 0, "gold", 0),
    (6, 0, "gold", 0),
]


@pytest.mark.parametrize(("miners", "paid", "ore", "shared"), TOGETHER)
def test_gold_is_for_two_to_four(miners: int, paid: float, ore: str, shared: int) -> None:
    scene = around(miners, STAGES[None]).step(mine(*range(miners)))
    scene.has(
        {
            "reward": [paid if agent < miners else 0 for agent in range(6)],
            "event ores_shared": shared,
            "event iron_mined": 0,
        }
    )
    assert scene.events["gold_mined"] == [int(reward == 8) for reward in scene.reward]
    assert ores(scene) == ore
    assert scene.value("rock.miners")[24] == ({0} if miners == 1 else set())  # (3, 3)


@BOTH
@pytest.mark.parametrize("later", [1, 2, 3, 4])
def test_the_second_miner_has_three_steps(stage: Stage, later: int) -> None:
    """The step of the first hit is one of them; after them a hit is a new first one."""
    scene = around(2, stage).step(mine(0)).has({"reward": 0})
    scene.step("", times=later - 1).step(mine(1)) if later > 1 else scene.step(mine(1))
    if later < 3:
        scene.has(
            {
                "reward": gold(stage, 0, 1),
                "event ores_shared": 1,
                "event gold_mined": counted(stage),
            }
        )
        assert ores(scene) == ""
    else:
        scene.has({"reward": 0, "event ores_shared": 0, "rock.miners": {(3, 3): {1}}})
        assert ores(scene) == "partial"
        scene.step(mine(0)).has({"reward": gold(stage, 1, 0)})


@BOTH
def test_alone_one_opens_the_ore_again_and_again(stage: Stage) -> None:
    """Partial for two observations, gold for one; hitting it once more does not prolong the time."""
    scene = around(1, stage)
    for ore in ["partial", "partial", "gold"] * 2:
        scene.step(mine(0)).has(
            {"reward": 0, "rock.miners": {(3, 3): set() if ore == "gold" else {0}}}
        )
        assert ores(scene) == ore


@BOTH
def test_a_second_hit_of_the_same_agent_does_not_count(stage: Stage) -> None:
    scene = around(2, stage).step(mine(0)).step(mine(0, 1))
    scene.has({"reward": gold(stage, 0, 1), "event gold_mined": counted(stage)})


@BOTH
def test_who_has_hit_is_paid_wherever_it_is(stage: Stage) -> None:
    """Agent 2, facing south at (2, 3), hits, goes one away from the ore and looks elsewhere."""
    scene = around(3, stage).step(mine(2)).step("stay, stay, turn_left")
    scene.step(mine(0)).has({"reward": gold(stage, 2, 0)})


# Who mines in each step -> whom the released code pays in the last one, at commit 9df972d
RELEASED_GOLD: list[tuple[list[list[int]], list[float]]] = [
    ([[0, 1]], [0, 8, 0, 0, 0, 0]),
    ([[0, 1, 2]], [0, 8, 0, 0, 0, 0]),
    ([[0, 1, 2, 3, 4, 5]], [0, 8, 0, 0, 0, 0]),
    ([[0], [0, 1]], [0, 8, 0, 0, 0, 0]),
    ([[0], [1, 2, 3]], [0, 8, 0, 0, 0, 0]),
    ([[2], [0, 1]], [8, 0, 0, 0, 0, 0]),
    ([[0], [], [1]], [0, 8, 0, 0, 0, 0]),
    ([[0], [], [], [1]], [0, 0, 0, 0, 0, 0]),
]


@pytest.mark.parametrize(("steps", "reward"), RELEASED_GOLD)
def test_as_released_gold_pays_who_completes_it(
    steps: list[list[int]], reward: list[float]
) -> None:
    scene = around(6, RELEASED)
    for miners in steps:
        scene.step(mine(*miners) if miners else "")
    paid = sum(reward) > 0
    scene.has(
        {
            "reward": reward,
            "event ores_shared": int(paid),
            "rock.miners": {(3, 3): set() if paid else {1}},
        }
    )
    assert ores(scene) == ("" if paid else "partial")
    assert sum(scene.events["gold_mined"]) == 2 * paid


# Growth


@BOTH
def test_ore_grows_on_bare_rock_where_nobody_stands(stage: Stage) -> None:
    """With certainty for iron: not in camps, not in walls, not where there is ore already. As released it grows under agents, too."""
    scene = put(
        stage,
        "OgOOOOO",
        EMPTY,
        "OOO^OOO  0",
        "OOOiOOO",
        EMPTY,
        "OOOOO#O",
        EMPTY,
        "vvvvvPP",
        under={0: "O"},
        spawn_iron=1,
    ).step()
    scene.shows(
        "igiiiii",
        "iiiiiii",
        "iii^iii",
        "iiiiiii",
        "iiiiiii",
        "iiiii#i",
        "iiiiiii",
        "vvvvvPP",
        under={0: "i" if stage is RELEASED else "O"},
    )


@BOTH
def test_gold_grows_where_no_iron_does(stage: Stage) -> None:
    grown = put(stage, *ROWS[:-1], "vvvvvvP", spawn_iron=1, spawn_gold=1).step()
    assert set(ores(grown).split()) == {"iron"}
    grown = put(stage, *ROWS[:-1], "vvvvvvP", spawn_gold=1).step()
    assert set(ores(grown).split()) == {"gold"} and len(ores(grown).split()) == 48


# Moves, starts, what is seen
