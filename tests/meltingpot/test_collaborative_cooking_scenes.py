"""Collaborative Cooking, scene by scene, on the interpreter. Source of the rules: Melting Pot's components of the same name."""

import pytest

from sjdsl.policies.interpreted import choose
from sjdsl.testing import Scene, Stage

# a counter beside the pot, tomatoes, dishes, a hatch; the cell between is reached from all four sides
ROWS = ("#C#D#", "O...T", "#.P.#", "P.P.P")
LOOKS = {"t": "counter item=tomato", "d": "counter item=dish"}
KITCHEN = Stage("collaborative_cooking", ROWS, 2, looks=LOOKS, interpreted=True)
DESK = Stage("collaborative_cooking", ("P.#.P", "O.#.D"), 2, looks=LOOKS, interpreted=True)
SHARED_POT = Stage("collaborative_cooking", ("P.C.P",), 2, interpreted=True)
AT_POT = ("#C#D#", "O^..T  0", "#.P.#", "P.P.^  1")


def cook(hand: str, tomatoes: int = 0, heat: int = 0, **params: float) -> Scene:
    fields = {"agent.hand": [hand, "none"], "pot.tomatoes": [tomatoes], "pot.heat": [heat]}
    return KITCHEN.put(*AT_POT, fields=fields, params=params)


def test_things_are_passed_over_a_counter() -> None:
    scene = DESK.put("P>#<P", "O.#.D", fields={"agent.hand": ["tomato", "none"]}).step(
        "interact, stay"
    )
    scene.has({"agent.hand": ["none", "none"], "event passed": [1, 0]}).shows("P>t<P", "O.#.D")
    scene.step("stay, interact").has({"agent.hand": ["none", "tomato"]}).shows("P>#<P", "O.#.D")


@pytest.mark.parametrize("seed", range(6))
def test_one_cook_a_counter_and_step(seed: int) -> None:
    """Both have a tomato, or one has and one has not: whoever is first exchanges, the other waits."""
    scene = DESK.put("P>#<P", "O.#.D", fields={"agent.hand": ["tomato", "tomato"]}, seed=seed).step(
        "interact, interact"
    )
    assert sorted(scene.value("agent.hand")) == ["none", "tomato"]
    scene = DESK.put("P>#<P", "O.#.D", fields={"agent.hand": ["tomato", "none"]}, seed=seed).step(
        "interact, interact"
    )
    hands = scene.value("agent.hand")
    assert hands in (["none", "none"], ["tomato", "none"])


@pytest.mark.parametrize(("tomatoes", "left"), [(0, "none"), (2, "none"), (3, "tomato")])
def test_a_pot_takes_three_tomatoes(tomatoes: int, left: str) -> None:
    scene = cook("tomato", tomatoes).step("interact")
    scene.has(
        {
            "agent.hand": [left, "none"],
            "pot.tomatoes": [min(tomatoes + 1, 3)],
            "event potted": [int(tomatoes < 3), 0],
        }
    )


def test_soup_is_ready_after_twenty_one_steps() -> None:
    """Melting Pot: the count that reaches 20 begins at 0 in the step of the third tomato, and the soup is there in the next."""
    scene = cook("tomato", 2).step("interact").has({"pot.heat": [1]})
    for step in range(1, 21):
        scene.step().has({"pot.heat": [step + 1]})
    scene.step().has({"pot.heat": [21]})
    for heat, hand in ((20, "dish"), (21, "soup")):
        scene = cook("dish", 3, heat).step("interact").has({"agent.hand": [hand, "none"]})
    scene.has({"pot.tomatoes": [0], "pot.heat": [0], "event poured": [1, 0]})


@pytest.mark.parametrize("hand", ["none", "tomato", "soup"])
def test_soup_needs_a_dish(hand: str) -> None:
    cook(hand, 3, 21).step("interact").has({"agent.hand": [hand, "none"], "pot.tomatoes": [3]})


def test_a_soup_pays_everybody() -> None:
    scene = KITCHEN.put(
        "#C#D#", "O..>T  0", "#.P.#", "P.P.^  1", fields={"agent.hand": ["soup", "none"]}
    ).step("interact")
    scene.has({"reward": [20, 20], "agent.hand": "none", "event delivered": [1, 0]})
    scene = KITCHEN.put(
        "#C#D#", "O..>T  0", "#.P.#", "P.P.^  1", fields={"agent.hand": ["dish", "none"]}
    ).step("interact")
    scene.has({"reward": 0, "agent.hand": ["dish", "none"]})


@pytest.mark.parametrize(("before", "after", "left"), [(0, 2, 0), (1, 3, 0), (2, 3, 1)])
def test_two_cooks_at_one_pot(before: int, after: int, left: int) -> None:
    scene = SHARED_POT.put(
        "P>C<P", fields={"agent.hand": ["tomato", "tomato"], "pot.tomatoes": [before]}
    ).step("interact, interact")
    scene.has({"pot.tomatoes": [after]})
    assert scene.value("agent.hand").count("tomato") == left


@pytest.mark.parametrize(("variant", "agents"), [(None, 1), ("circuit", 1), ("asymmetric", 2)])
def test_scripted_cooks_deliver(variant: str | None, agents: int) -> None:
    scene, delivered = (
        Stage("collaborative_cooking", agents=agents, variant=variant, interpreted=True).start(1),
        0,
    )
    cook = next(policy for policy in scene.env.game.policies if policy.name == "cook")
    for _ in range(120):
        chosen = [
            choose(cook, scene.env.game, scene.world, agent, (1, 2)) for agent in range(agents)
        ]
        scene.step(", ".join(scene.env.action_names[action] for action in chosen))
        delivered += sum(scene.value("event delivered"))
    assert delivered > 0
