"""Daycare, scene by scene, on the interpreter: who picks what, eats what, and how long a child lives. Source: Melting Pot's components."""

import pytest

from sjdsl.testing import Scene, Stage

LOOKS = {
    **{"A": "plot plant=apple_tree fruit=ripe", "B": "plot plant=banana_tree fruit=ripe"},
    "a": "plot plant=apple_shrub fruit=ripe",  # `b`, a shrub of bananas, is a glyph of the game
    **{
        "o": "plot lies=banana",
        "T": "plot plant=banana_tree",
        "g": "plot plant=banana_shrub fruit=growing",
    },
}
ROWS = ("#######", "#~~~~~#", "#PPP~~#", "#~~~~~#", "#######")
STAGE = Stage("daycare", ROWS, 2, looks=LOOKS, interpreted=True)
ROLES = {"agent.role": ["child", "parent"]}


def put(*middle: str, seed: int = 0, **fields: object) -> Scene:
    """Returns a scene of a child, agent 0, and a parent; `middle` are the three rows between the walls."""
    told = {f"agent.{name}": value for name, value in fields.items()}
    return STAGE.put("#######", *middle, "#######", fields=ROLES | told, seed=seed)


@pytest.mark.parametrize(
    ("plant", "fruit"), [("A", "apple"), ("B", "banana"), ("a", "apple"), ("b", "banana")]
)
def test_a_parent_picks_everything(plant: str, fruit: str) -> None:
    scene = put("#~~~~~#", f"#^P~>{plant}#  01", "#~~~~~#").step("stay, grasp")
    scene.has({"agent.hand": ["none", fruit], "event picked": [0, 1]})


@pytest.mark.parametrize(("plant", "share"), [("A", 0.0), ("B", 0.0), ("a", 0.3), ("b", 0.3)])
def test_a_child_picks_of_shrubs_by_luck(plant: str, share: float) -> None:
    """120 tries: the standard deviation of a share of 0.3 is 0.042; the bound is four of them."""
    picked = 0
    for seed in range(120):
        scene = put("#~~~~~#", f"#^P~>{plant}#  10", "#~~~~~#", seed=seed).step("grasp")
        picked += scene.value("agent.hand")[0] != "none"
    assert abs(picked / 120 - share) <= 4 * 0.042 * (share > 0)


def test_what_lies_on_the_ground_is_anybodys() -> None:
    put("#~~~~~#", "#^P~>o#  10", "#~~~~~#").step("grasp").has(
        {"agent.hand": ["banana", "none"]}
    ).shows("#######", "#~~~~~#", "#^P~>~#  10", "#~~~~~#", "#######")


def test_a_grasp_counts_after_a_step_without() -> None:
    scene = (
        put("#~~~~~#", "#^P~>b#  01", "#~~~~~#")
        .step("stay, grasp")
        .has({"agent.hand": ["none", "banana"]})
    )
    scene.step("stay, grasp").has({"agent.hand": ["none", "banana"]})
    scene.step("stay, turn_right").step("stay, grasp").has({"agent.hand": "none"})
    assert scene.value("plot.lies").count("banana") == 1


@pytest.mark.parametrize(
    ("agent", "fruit", "pay"),
    [(0, "apple", 0), (0, "banana", 1), (1, "apple", 1), (1, "banana", 1)],
)
def test_what_eating_pays(agent: int, fruit: str, pay: int) -> None:
    hands = ["none", "none"]
    hands[agent] = fruit
    scene = put("#~~~~~#", "#^P~>~#  01", "#~~~~~#", hand=hands).step("eat, eat")
    scene.has({"reward": [pay if i == agent else 0 for i in range(2)], "agent.hand": "none"})


def test_a_parent_alone_gains_nothing() -> None:
    scene = STAGE.put(
        "#######",
        "#~~~~~#",
        "#PP~>~#  1",
        "#~~~~~#",
        "#######",
        fields=ROLES | {"agent.hand": ["none", "apple"]},
        away={0: 50},
    )
    scene.step("stay, eat").has({"reward": 0, "agent.hand": "none"})


def test_only_bananas_still_hunger() -> None:
    scene = (
        put("#~~~~~#", "#^P~>~#  01", "#~~~~~#", hand=["banana", "none"], hunger=[7, 200])
        .step("eat")
        .has({"agent.hunger": [200, 200]})
    )
    scene.step().has({"agent.hunger": [199, 200]})
    put("#~~~~~#", "#^P~>~#  01", "#~~~~~#", hand=["apple", "none"], hunger=[7, 200]).step(
        "eat"
    ).has({"agent.hunger": [6, 200]})


def test_a_hungry_child_is_away_and_comes_back_beside_a_parent() -> None:
    scene = (
        put("#~~~~~#", "#^P~>~#  01", "#~~~~~#", hunger=[2, 200]).step().has({"agent.away": False})
    )
    scene.step("", 101).has({"agent.away": [True, False]})
    scene.step().has(
        {"agent.away": False, "agent.heading": ["north", "east"], "agent.hunger": [200, 200]}
    )
    (row, col), parent = scene.places()[0], (2, 4)
    assert abs(row - parent[0]) + abs(col - parent[1]) == 1


@pytest.mark.parametrize("by_hunger", [False, True])
def test_the_plant_of_an_eaten_fruit_bears_again(by_hunger: bool) -> None:
    """Fifty-one steps after the fruit was eaten, or was lost with a hungry child, and not before it was."""
    agent, numbers = (0, "10") if by_hunger else (1, "01")
    scene = put("#~~~~~#", f"#^P~>b#  {numbers}", "#~~~~~#", hunger=[61, 200]).step(
        "grasp" if agent == 0 else "stay, grasp"
    )
    if scene.value("agent.hand")[agent] == "none":
        scene = next(
            s
            for s in (
                put("#~~~~~#", "#^P~>b#  10", "#~~~~~#", hunger=[61, 200], seed=n).step("grasp")
                for n in range(30)
            )
            if s.value("agent.hand")[0] != "none"
        )
    scene.step("", 59)
    scene.step("" if by_hunger else "stay, eat")
    assert scene.value("plot.fruit").count("growing") == 1
    scene.step("", 50)
    assert "ripe" not in scene.value("plot.fruit")
    scene.step()
    assert scene.value("plot.fruit").count("ripe") == 1


def test_who_sees_what() -> None:
    """A child takes trees for shrubs, a parent bananas for apples; each sees its own hunger."""
    scene = put("#ABab~#", "#^P~>~#  01", "#~~~~~#", hand=["banana", "banana"])
    assert [scene.seen(0, "content", ahead=1, right=n) for n in range(4)] == [
        *(
            "plot plant=apple_shrub fruit=ripe lies=nothing",
            "plot plant=banana_shrub fruit=ripe lies=nothing",
        ),
        *(
            "plot plant=apple_shrub fruit=ripe lies=nothing",
            "plot plant=banana_shrub fruit=ripe lies=nothing",
        ),
    ]
    shrub = "plot plant=apple_shrub fruit=ripe lies=nothing"
    assert [scene.seen(1, "content", right=-1, ahead=n) for n in (-1, 0)] == [shrub, shrub]
    assert (
        scene.seen(0, "agent.hand"),
        scene.seen(1, "agent.hand"),
        scene.seen(0, "agent.hunger"),
    ) == ("banana", "apple", 200)


def test_an_episode_starts_in_the_yard_among_plants() -> None:
    """1 - 0.8 of 207 plots: 41 plants on average, with a standard deviation of 6."""
    scene = (
        Stage("daycare", interpreted=True)
        .start(3)
        .has({"agent.role": ["child", "parent"], "agent.hunger": 200})
    )
    assert all(row in (5, 6, 7) and col in (8, 9, 10) for row, col in scene.places())
    plants, fruit = scene.value("plot.plant"), scene.value("plot.fruit")
    assert len(plants) == 11 * 18
    assert abs(sum(plant != "bare" for plant in plants) - 0.2 * 189) < 4 * 6
    assert all((f == "ripe") is (plant != "bare") for plant, f in zip(plants, fruit, strict=True))
