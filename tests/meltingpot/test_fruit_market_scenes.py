"""Fruit Market, scene by scene: picking, eating, bargaining, tiring, and holding others. Source: Melting Pot's components."""

from typing import Any

import pytest

from sjdsl.testing import Scene, Stage

ROWS = ("P......~", "........", "P.....P~")
STAGE = Stage(
    "fruit_market", ROWS, 3, params={"apples": 0, "bananas": 0, "skill": 0}, interpreted=True
)


def put(*picture: str, fields: dict[str, Any] | None = None, **facts: Any) -> Scene:
    """Returns a scene in which agent 0 picks apples and the others bananas; nobody is hungry, no tree stands unless told."""
    given = {"agent.farms": ["apple", "banana", "banana"], "agent.hunger": 200, **(fields or {})}
    return STAGE.put(*picture, fields=given, **facts)


def test_fruit_is_picked_by_who_comes_to_a_ripe_tree() -> None:
    """Two at once of one's own kind; then the tree bears again in fifty steps, also for who stands there."""
    scene = put(
        ">......~", "......v.  1", "P.....v~  2", fields={"ground.tree": {(0, 1): "apple"}}
    ).step("forward")
    scene.has({"agent.bag[apple]": [2, 0, 0], "event picked": [1, 0, 0]}).step(times=50)
    scene.has({"ground.fruit": {(0, 1): "unripe"}, "agent.bag[apple]": {0: 2}}).step().has(
        {"agent.bag[apple]": {0: 4}}
    )
    scene.step("forward").step(times=51).has({"ground.fruit": "ripe"}).step("backward").has(
        {"agent.bag[apple]": {0: 6}}
    )


@pytest.mark.parametrize("skill", [0, 1])
def test_the_other_fruit_is_picked_by_chance(skill: int) -> None:
    fields = {"ground.tree": {(0, 1): "banana"}}
    scene = put(
        ">......~", "......v.  1", "P.....v~  2", fields=fields, params={"skill": skill}
    ).step("forward")
    scene.has({"agent.bag[banana]": {0: 2 * skill}}).step().has(
        {"agent.bag[banana]": {0: 2 * skill}}
    )


def test_the_fruit_one_is_bad_at_is_worth_eight() -> None:
    scene = put(
        ">......~",
        "......v.  1",
        "P.....v~  2",
        fields={"agent.bag[apple]": [1, 1, 0], "agent.bag[banana]": 1},
    )
    scene.step("eat(apple), eat(apple), eat(apple)").has(
        {"reward": [1, 8, 0], "agent.bag[apple]": 0, "agent.hunger": [49, 49, 199]}
    )
    scene.step("eat(banana), eat(banana)").has(
        {"reward": [8, 1, 0], "agent.bag[banana]": [0, 0, 1]}
    )


def test_offers_that_fit_are_traded_and_gone() -> None:
    """Each gets what it asks for, though more is offered. Source: the smallest number that satisfies both."""
    fields = {"agent.bag[apple]": [5, 0, 0], "agent.bag[banana]": [0, 5, 0]}
    scene = put(">..<...~  01", "........", "P.....v~  2", fields=fields).step(
        "offer(banana, 1, 3), stay"
    )
    scene.has({"agent.wants": ["banana", "none", "none"], "event trades": 0}).step(
        "stay, offer(apple, 2, 2)"
    )
    scene.has(
        {
            "agent.bag[apple]": [3, 2, 0],
            "agent.bag[banana]": [1, 4, 0],
            "agent.wants": "none",
            "event trades": [1, 1, 0],
        }
    )


@pytest.mark.parametrize(
    ("first", "second", "bananas", "col"),
    [
        ("offer(banana, 2, 1)", "offer(apple, 2, 2)", 5, 3),
        ("offer(banana, 1, 1)", "offer(apple, 1, 1)", 0, 3),
        ("offer(banana, 1, 1)", "offer(apple, 1, 1)", 5, 5),
        ("offer(banana, 1, 1)", "offer(banana, 1, 1)", 5, 3),
    ],
    ids=["asks too much", "cannot pay", "too far", "the same fruit"],
)
def test_other_offers_are_not(first: str, second: str, bananas: int, col: int) -> None:
    row = [*">......~"]
    row[col] = "<"
    fields = {"agent.bag[apple]": [5, 0, 0], "agent.bag[banana]": [0, bananas, 0]}
    scene = (
        put("".join(row) + "  01", "........", "P.....v~  2", fields=fields)
        .step(f"{first}, {second}")
        .has({"event trades": 0})
    )
    scene.step("cancel, cancel").has({"agent.wants": "none"})


def test_the_better_offer_is_taken() -> None:
    """Agent 2 asks for one apple where agent 1 asks for two."""
    fields = {"agent.bag[apple]": [5, 0, 0], "agent.bag[banana]": 5}
    scene = put(">.<<...~  012", "........", "P.....P~", fields=fields).step(
        "offer(banana, 1, 2), offer(apple, 2, 1), offer(apple, 1, 1)"
    )
    scene.has(
        {
            "event trades": [1, 0, 1],
            "agent.bag[apple]": [4, 0, 1],
            "agent.wants": ["none", "apple", "none"],
        }
    )


def test_every_second_step_costs_stamina_and_rest_restores_it() -> None:
    """But not on a tree."""
    scene = put(
        ">......~", "......v.  1", "P.....v~  2", fields={"ground.tree": {(0, 4): "banana"}}
    ).step("forward, turn_left")
    scene.has({"agent.stamina": 18}).step("forward").has({"agent.stamina": [17, 18, 18]}).step(
        "forward"
    ).step("forward")
    scene.has({"agent.stamina": {0: 16}}).step(times=3).has({"agent.stamina": {0: 16}}).step(
        "forward"
    ).step()
    scene.has({"agent.stamina": {0: 17}})


def test_water_and_hunger_cost_stamina() -> None:
    fields = {"agent.stamina": 10, "agent.hunger": [200, 2, 200]}
    scene = put("P......>  0", "......v.  1", "P.....v~  2", fields=fields, under={0: "~"}).step(
        "turn_left, turn_left"
    )
    scene.has({"agent.stamina": [10, 11, 11]}).step().has(
        {"agent.stamina": [10, 12, 12]}
    ).step().has({"agent.stamina": [10, 12, 13]})
    scene.step("forward").has({"agent.stamina": {0: 9}})


@pytest.mark.parametrize(("stamina", "pause"), [(8, 0), (6, 2), (0, 6)])
def test_who_is_tired_rests_after_each_step(stamina: int, pause: int) -> None:
    """And neither recovers nor tires further meanwhile."""
    scene = put(
        ">......~", "......v.  1", "P.....v~  2", fields={"agent.stamina": {0: stamina}}
    ).step("forward")
    for _ in range(pause):
        scene.has({"allowed forward": {0: False}, "agent.stamina": {0: stamina}}).step(
            "forward"
        ).has({"agent.col": {0: 1}})
    scene.has({"allowed forward": {0: True}}).step("forward").has({"agent.col": {0: 2}})


def test_who_is_held_cannot_walk_and_can_be_pushed_and_pulled() -> None:
    """Up to two cells ahead; the one who holds cannot walk either, and can go on holding."""
    scene = put(">.<....~  01", "........", "P.....v~  2").step("hold")
    scene.has({"allowed forward": [False, False, True], "allowed hold": [True, False, True]}).step(
        "hold, backward"
    ).has({"agent.col": {1: 2}})
    scene.step("shove").has({"agent.col": {1: 3}}).step(times=2).has({"allowed forward": True})
    put(">.<....~  01", "........", "P.....v~  2").step("pull").has({"agent.col": {1: 1}})
    put("><.....~  01", "........", "P.....v~  2").step("pull").has({"agent.col": {0: 0, 1: 1}})
    put(">..<...~  01", "........", "P.....v~  2").step("shove").has(
        {"agent.col": {1: 3}, "allowed forward": True}
    )


def test_half_of_the_players_pick_apples_and_trees_are_drawn() -> None:
    stage = Stage("fruit_market", interpreted=True)
    scene = stage.start(2).has({"agent.farms": ["apple"] * 8 + ["banana"] * 8})
    trees = scene.value("ground.tree")
    assert {scene.under(agent) for agent in range(16)} <= {"P", "?"}
    assert 5 < trees.count("apple") < 60
    assert 5 < trees.count("banana") < 60
