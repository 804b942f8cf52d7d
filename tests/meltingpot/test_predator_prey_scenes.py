"""Predator and Prey as Melting Pot has it, scene by scene: stamina, company, acorns eaten in thirds, grass that is not always there."""

from typing import Any

import pytest

from sjdsl.testing import Scene, Stage

ROWS = ("XXhhPP", "......", "aan.gg", "......")
STAGE = Stage("predator_prey_open", ROWS, 3, params={"hunters": 1, "absence": 4}, interpreted=True)
FIXED = {"growth": {"apple": 0, "acorn": 0}}
PREDATOR = {"agent.role": {0: "predator"}}


def put(*picture: str, **facts: Any) -> Scene:
    """Returns a scene in which agent 0 is the predator and nothing grows, unless told."""
    fields = {**PREDATOR, **facts.pop("fields", {})}
    return STAGE.put(*picture, params={**FIXED, **facts.pop("params", {})}, fields=fields, **facts)


@pytest.mark.parametrize(("stamina", "rest"), [(18, 1), (8, 1), (7, 2), (2, 2), (1, 4), (0, 4)])
def test_prey_rests_the_longer_the_more_tired_it_is(stamina: int, rest: int) -> None:
    """It cannot move in so many steps after an action. Source: Melting Pot."""
    scene = put(
        "XXhhPP", ">.....  1", "aan.gg", "<....^  02", fields={"agent.stamina": {1: stamina}}
    )
    moved = [scene.step("stay, forward").value("agent.moved")[1] for _ in range(rest + 2)]
    assert moved == [True, *[False] * rest, True]


@pytest.mark.parametrize(("stamina", "rest"), [(18, 0), (8, 0), (7, 1), (2, 1), (1, 6), (0, 6)])
def test_predators_are_quick_and_tire_faster(stamina: int, rest: int) -> None:
    rows = ("." * 10, "X.hhPP....")
    stage = Stage("predator_prey_open", rows, 3, params={"hunters": 1}, interpreted=True)
    scene = stage.put(
        ">" + "." * 9, "X.hh^^....", fields={**PREDATOR, "agent.stamina": {0: stamina}}
    )
    moved = [scene.step("forward").value("agent.moved")[0] for _ in range(rest + 2)]
    assert moved == [True, *[False] * rest, True]


def test_rest_restores_stamina_and_the_time_of_freezing_does_not() -> None:
    scene = put(
        "XXhhPP", ">.....  1", "aan.gg", "<....^  02", fields={"agent.stamina": {1: 5}}
    ).step("stay, forward")
    scene.has({"agent.stamina": {1: 4}}).step(times=2).has({"agent.stamina": {1: 4}}).step().has(
        {"agent.stamina": {1: 5}}
    )


def test_prey_is_eaten_alone_and_not_in_company() -> None:
    """Prey alone: one against one. With another beside it: two against one."""
    alone = (
        put("XX^hPP  2", "......", "aan.gg", "><....  01")
        .step("bite")
        .has({"agent.away": [False, True, False], "reward": [1, 0, 0]})
    )
    alone.step(times=3).has({"agent.away": {1: True}}).step().has(
        {"agent.away": {1: False}, "agent.stamina": {1: 18}}
    )
    assert alone.places()[1] in {(0, 2), (0, 3), (0, 4), (0, 5)}
    together = (
        put("XXhhPP", "......", "aan.gg", "><<...  012")
        .step("bite")
        .has({"agent.away": False, "reward": 0, "agent.alert": [0, 5, 5]})
    )
    assert together.seen(0, "other.alert", ahead=1) == "alarmed"


@pytest.mark.parametrize(
    "fields", [{"agent.mouth": {2: "eating"}, "agent.chews": {2: 9}}, {"agent.stamina": {2: 0}}]
)
def test_who_eats_an_acorn_or_is_spent_is_no_company(fields: dict[str, Any]) -> None:
    put("XXhhPP", "......", "aan.gg", "><<...  012", fields=fields).step("bite").has(
        {"agent.away": {1: True}, "reward": [1, 0, 0]}
    )


def test_a_predator_that_has_eaten_stays_for_four_steps_and_bites_on() -> None:
    """Whoever comes before it meanwhile is eaten, without another bite."""
    scene = put("XXhhPP", "......", "aan.gg", "><...<  012", params={"quick": {"prey": 0}}).step(
        "bite"
    )
    scene.has({"agent.away": [False, True, False], "reward": [1, 0, 0]})
    scene.step("forward, stay, forward", times=3).shows("XXhhPP", "......", "aan.gg", ">.<...  02")
    scene.step("forward, stay, forward").has(
        {"agent.away": {2: True}, "reward": [1, 0, 0], "event caught": [1, 0, 0]}
    )
    held = put("XXhhPP", "......", "aan.gg", "><...<  012").step("bite").step("forward", times=4)
    assert held.places()[0] == (3, 0)
    assert held.step("forward").places()[0] == (3, 1)


def test_an_acorn_is_eaten_in_thirds_by_who_is_rested() -> None:
    facts = {"fields": {"agent.hand": {1: "acorn"}}}
    tired = put(
        "XXhhPP",
        "....>.  1",
        "aan.gg",
        "<....^  02",
        fields={**facts["fields"], "agent.stamina": {1: 12}},
    ).step("stay, bite")
    tired.has({"agent.hand": {1: "acorn"}, "agent.mouth": "empty"})
    scene = (
        put("XXhhPP", "....>.  1", "aan.gg", "<....^  02", **facts)
        .step("stay, bite")
        .has({"agent.mouth": {1: "eating"}})
    )
    rewards = [scene.step("stay, stay").reward[1] for _ in range(26)]
    assert [step for step, reward in enumerate(rewards, 1) if reward] == [11, 16, 21]
    assert sum(rewards) == 18
    scene.has({"agent.mouth": {1: "empty"}, "event acorns": [0, 1, 0]})


@pytest.mark.parametrize("variant", [None, "described"])
def test_prey_walks_while_it_eats_and_takes_another_acorn_but_not_as_described(
    variant: str | None,
) -> None:
    stage = Stage(
        "predator_prey_open",
        ROWS,
        3,
        params={"hunters": 1, "quick": {"prey": 0}},
        variant=variant,
        interpreted=True,
    )
    fields = {**PREDATOR, "agent.mouth": {1: "eating"}, "agent.chews": {1: 9}}
    scene = stage.put(
        "XXhhPP", "......", "a>n.gg  1", "<....^  02", fields=fields, params=FIXED
    ).step("stay, forward")
    scene.has(
        {
            "agent.moved": {1: variant is None},
            "agent.hand": {1: "empty" if variant else "acorn"},
            "agent.mouth": {1: "eating"},
        }
    )


def test_all_predators_that_bite_one_prey_are_paid() -> None:
    """And stay where they are for four steps, in which trying to walk tires them."""
    stage = Stage("predator_prey_open", ROWS, 3, params={"hunters": 2}, interpreted=True)
    roles = {"agent.role": ["predator", "predator", "prey"]}
    scene = stage.put("XXhhPP", "......", "aan.gg", "><<...  021", fields=roles, params=FIXED).step(
        "bite, bite"
    )
    scene.has(
        {
            "reward": [1, 1, 0],
            "event caught": [1, 1, 0],
            "event eaten": [0, 0, 1],
            "agent.away": {2: True},
        }
    )
    scene.step("backward, stay").has({"agent.moved": False, "agent.stamina": {0: 16, 1: 18}})


def test_grass_keeps_predators_out_where_it_stands() -> None:
    scene = (
        put("XXhhPP", "....v.  0", "aan.gg", "^....^  12")
        .step("forward")
        .shows("XXhhPP", "....v.", "aan.gg", "^....^")
    )
    scene = put("XXhhPP", "....v.  0", "aan.gg", "^....^  12", fields={"grass.stands": "no_"}).step(
        "forward"
    )
    assert scene.places()[0] == (2, 4)
    assert put("XXhhPP", "....v.  1", "aan.gg", "^....^  02").step("stay, forward").places()[1] == (
        2,
        4,
    )


def test_forests_differ_and_every_third_uncertain_place_has_something() -> None:
    """200 places of each sort: five standard deviations are 0.17."""
    rows = ("M" * 40,) * 5 + ("N" * 40,) * 5 + ("XXPP" * 10,)
    stage = Stage("predator_prey_open", rows, 3, params={"hunters": 1}, interpreted=True)
    scene = stage.start(seed=1)
    for kind in ("grass", "tree"):
        stands = scene.value(f"{kind}.stands")
        assert abs(stands.count("yes_") / 200 - 1 / 3) < 0.17
    assert set(zip(scene.value("tree.stands"), scene.value("tree.fruit"), strict=True)) == {
        ("yes_", "ripe"),
        ("no_", "none"),
    }
