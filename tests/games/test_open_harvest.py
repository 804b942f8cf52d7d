"""Open Harvest, scene by scene: what an apple pays, how it ripens and rots, when a cell bears again, and what a zap does."""

from typing import Any

import pytest

from sjdsl.testing import Scene

from .environments import stage_of

HUES = ("red", "yellow", "green", "cyan", "purple")
RANKS = ("best", "middling", "worst")
ORDERS = ("uro", "uor", "ruo", "rou", "our", "oru")
STAGES = {"u": "unripe", "r": "ripe", "o": "overripe"}
LOOKS = {
    "u": "tree fruit=unripe",
    "b": "tree fruit=bare",
    "r": "tree fruit=ripe",
    "o": "tree fruit=overripe",
    "x": "tree fruit=rotted",
}
STAGE = stage_of("open_harvest", ("111.", "111.", "PPPP"), 2, looks=LOOKS)
NONE_GROWS = {"regrow_1": 0.0, "regrow_2": 0.0, "regrow_3": 0.0}


def put(*rows: str, pay: str = "uro", speed: str = "uro", **rest: Any) -> Scene:
    """Returns a scene in which all hues have the same orders, and no apple ripens in the next steps."""
    fields = {
        "pay_order": dict.fromkeys(HUES, pay),
        "speed_order": dict.fromkeys(HUES, speed),
        "tree.left": 9,
        **rest.pop("fields", {}),
    }
    return STAGE.put(*rows, fields=fields, **rest)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("place", range(3))
def test_an_order_names_the_stages_from_best_to_worst(order: str, place: int) -> None:
    """Released code: 1, 0.5 and 0.25 points."""
    letter = order[place]
    scene = put(f"1{letter}1.", "1^1<", "PPPP", pay=order, under={0: "b"}).step("forward, stay")
    scene.has({"reward": [1 / 2**place, 0], f"event eaten[{RANKS[place]}]": [1, 0]})
    scene.has({"tree.fruit": {(0, 1): "bare"}, "tree.taken": {(0, 1): STAGES[letter]}})


def test_each_hue_has_orders_of_its_own() -> None:
    orders = {**dict.fromkeys(HUES, "uro"), "cyan": "oru"}
    hues = {(0, 0): "cyan", (0, 2): "red"}
    scene = put("111.", "^1^.", "PPPP", fields={"pay_order": orders, "tree.hue": hues})
    scene.step("forward, forward").has({"reward": [0.25, 1]})


def test_an_apple_stays_as_long_at_each_stage_then_rots_and_its_cell_bears_again() -> None:
    scene = put(
        "111.",
        "111<",
        "PPP<",
        fields={"tree.left": 1, "tree.pace": 17},
        params={**NONE_GROWS, "rot_least": 2, "rot_most": 2},
    )
    for stage in ("ripe", "overripe"):
        scene.step().has({"tree.fruit": stage})
        scene.step(times=16).has({"tree.fruit": stage})
    scene.step().has({"tree.fruit": "rotted", "event rots": 6})
    scene.step().has({"tree.fruit": "rotted"})
    scene.step().has({"tree.fruit": "unripe", "event grown": 6})


def test_nothing_grows_under_an_agent() -> None:
    rotted = {"tree.left": 0}
    scene = put("xbb.", "^bb<", "PPPP", under={0: "x"}, fields=rotted, params=NONE_GROWS).step()
    scene.has({"tree.fruit": {(0, 0): "unripe", (1, 0): "rotted"}})
    scene.step("step_right, stay").has({"tree.fruit": {(1, 0): "rotted"}})
    scene.step().has({"tree.fruit": {(1, 0): "unripe"}})


@pytest.mark.parametrize(
    ("row", "below", "rate"),
    [
        ("bbb.", "bbu.", None),  # the apple is farther away than 2
        ("bub.", "bbu.", "regrow_1"),
        ("bur.", "bbb.", "regrow_2"),
        ("bor.", "ubb.", "regrow_3"),
        ("bxx.", "xub.", "regrow_1"),
        ("bur.", "oub.", "regrow_3"),
    ],
)
def test_a_bare_cell_bears_by_how_many_apples_are_near(
    row: str, below: str, rate: str | None
) -> None:
    """A rate of a quarter is certain at a speed of 4."""
    for on in NONE_GROWS:
        params = {**NONE_GROWS, on: 0.25, "speed": dict.fromkeys(RANKS, 4.0)}
        scene = put(row, below, "<<PP", params=params).step()
        assert (scene.value("tree.fruit")[0] == "unripe") == (on == rate)


@pytest.mark.parametrize("order", ORDERS)
def test_how_fast_a_cell_bears_depends_on_the_stage_at_which_its_last_apple_was_eaten(
    order: str,
) -> None:
    for place, letter in enumerate(order):
        params: dict[str, Any] = {**NONE_GROWS, "regrow_3": 0.25}
        speeds = dict.fromkeys(RANKS, 0.0)
        params["speed"] = {**speeds, RANKS[place]: 4.0}
        for taken in STAGES.values():
            scene = put(
                "b11.", "11b.", "<<PP", speed=order, params=params, fields={"tree.taken": taken}
            ).step()
            assert (scene.value("tree.fruit")[0] == "unripe") == (taken == STAGES[letter])


def test_who_is_hit_stands_at_a_gate_and_cannot_act_and_a_zap_needs_a_pause() -> None:
    """Harness: 12 steps. Released code: 2 steps between zaps."""
    scene = put("bbb.", "b>b<", "PPPP", under={0: "b"}, params=NONE_GROWS)
    scene.step("zap, stay").has({"event hits": [1, 0], "agent.frozen": [0, 12]})
    place = scene.places()[1]
    assert place is not None and place[0] == 2
    scene.has({"allowed zap": [False, False], "allowed forward": [True, False]})
    scene.step("stay, forward", times=2).has({"allowed zap": [True, False]})
    scene.step("stay, forward", times=10).has({"allowed forward": [True, True]})
    assert scene.places()[1] == place


def test_a_patch_has_one_hue_that_stays_for_all_trials_and_so_do_the_rules() -> None:
    stage = stage_of("open_harvest", ("123P", "456P"), 2, params={"length": 3})
    seen = set()
    for seed in range(6):
        scene = stage.start(seed)
        names = ("tree.hue", "pay_order", "speed_order")
        before = [scene.value(name) for name in names]
        scene.step(times=7).has({"trial": 2})
        assert [scene.value(name) for name in names] == before
        seen.add(tuple(before[0]))
    assert len(seen) == 6
