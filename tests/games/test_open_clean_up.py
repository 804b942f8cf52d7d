"""Open Clean Up, scene by scene: tools made by two pick-ups, what each does to which waste, new waste, and the hidden recipes."""

from typing import Any

import pytest

from sjdsl.testing import Scene

from .environments import stage_of

THINGS = ("flint", "cord", "reed", "clay")  # the stations 1, 2, 3 and 4
RECIPES = {"red": 0, "yellow": 1, "green": 2, "cyan": 3, "purple": 4, "mid": 14, "dark": 15}
LOOKS = {"m": "water state=mid", "d": "water state=dark"}
RIVER = stage_of("open_clean_up", ("HHH.", "HHH.", "SPPB"), 2, looks=LOOKS)
STORE = stage_of("open_clean_up", ("1234", "FHP.", "BPPP"), 2)
CALM = {"pollution": 0.0, "best_rate": 0.0}


def put(*rows: str, holds: int | None = None, hue: str = "green", **rest: Any) -> Scene:
    """Returns a scene in which agent 0 holds the pair of this number; the recipes are `RECIPES`, and all waste has one hue."""
    fields: dict[str, Any] = {"recipe": RECIPES, "main_hue": hue, "water.hue": hue}
    if holds is not None:
        fields["agent.older"] = {0: THINGS[holds // 4]}
        fields["agent.newer"] = {0: THINGS[holds % 4]}
    return RIVER.put(*rows, fields=fields, **{"params": CALM, **rest})


def test_the_last_two_things_picked_up_are_held_in_order() -> None:
    scene = STORE.put(">234", "FHP.", "BPP<", under={0: "1"}, params=CALM)
    scene.step("pick_up, pick_up").has({"agent.newer": ["flint", "none"], "event picks": [1, 0]})
    scene.step("step_right, stay").has({"agent.newer": ["flint", "none"]})
    scene.step("pick_up").has({"agent.older": ["flint", "none"], "agent.newer": ["cord", "none"]})
    scene.step("pick_up").has({"agent.older": ["cord", "none"], "agent.newer": ["cord", "none"]})


@pytest.mark.parametrize(
    ("holds", "after"),
    [
        (RECIPES["green"], ("HmH.", "dHH.", "S^P<")),
        (RECIPES["mid"], ("HFH.", "dFH.", "S^P<")),
        (RECIPES["dark"], ("HmH.", "mFH.", "S^P<")),
        (RECIPES["red"], ("HmH.", "dFH.", "S^P<")),  # of another hue
        (7, ("HmH.", "dFH.", "S^P<")),  # no recipe
        (None, ("HmH.", "dFH.", "S^P<")),
    ],
)
def test_a_tool_changes_one_shade_in_the_four_cells_of_the_beam(
    holds: int | None, after: tuple[str, ...]
) -> None:
    scene = put("HmH.", "dFH.", "S^P<", holds=holds).step("clean, stay").shows(*after)
    scene.has({"event cleared": [int(holds == RECIPES["green"]), 0], "event shots": [1, 0]})
    scene.has({"event thinned": [int(holds in (RECIPES["mid"], RECIPES["dark"])), 0]})


def test_dark_waste_needs_three_shots_with_three_tools() -> None:
    rows = ("HHH.", "HdH.", "S^P<")
    for name, sign in (("dark", "m"), ("mid", "F"), ("green", "H")):
        scene = put(*rows, holds=RECIPES[name]).step("clean, stay", times=2)
        rows = ("HHH.", f"H{sign}H.", "S^P<")
        scene.shows(*rows)


def test_a_tool_works_on_the_hue_of_its_recipe() -> None:
    for hue, number in RECIPES.items():
        if hue not in ("mid", "dark"):
            scene = put("HHH.", "HFH.", "S^P<", holds=number, hue=hue).step("clean, stay")
            scene.shows("HHH.", "HHH.", "S^P<")


@pytest.mark.parametrize(("waste", "grows"), [(2, True), (3, False)])
def test_apples_grow_below_a_dirt_of_two_fifths_of_river_and_stream(
    waste: int, grows: bool
) -> None:
    """Released code: the stream counts, and never gets dirty: 2 of 7 cells, and 3 of 7."""
    rows = ("H" * (3 - waste) + "F" * waste + ".", "HHH.", "SPPB")
    scene = put(rows[0], "HHH.", "S^<B", params={**CALM, "best_rate": 1.0})
    ripe = False
    for _ in range(20):
        ripe |= scene.step().value("orchard.fruit") == ["ripe"]
    assert ripe == grows


@pytest.mark.parametrize(("step", "falls"), [(50, False), (51, True)])
def test_waste_falls_after_fifty_one_steps_in_the_hue_of_the_episode(
    step: int, falls: bool
) -> None:
    """Released code: from step 51 on, counted from 0."""
    params = {"pollution": 1.0, "best_rate": 0.0}
    scene = put("HHH.", "HHH.", "S^P<", hue="cyan", step=step, params=params).step()
    dirty = [state for state in scene.value("water.state") if state != "clean"]
    assert len(dirty) == falls
    scene.has({"water.hue": "cyan"})


def test_no_waste_falls_where_somebody_stands() -> None:
    stage = stage_of("open_clean_up", ("HP..", "SPPB"), 2)
    for seed in range(3):
        scene = stage.put("^P..", "SPP<", step=60, seed=seed, params={"pollution": 1.0}).step()
        scene.has({"water.state": "clean"})


def test_what_is_held_is_lost_at_the_end_of_a_trial_and_the_recipes_are_not() -> None:
    stage = stage_of("open_clean_up", ("FF1P", "HS2P", "BPPP"), 2, params={"length": 3})
    for seed in range(4):
        scene = stage.start(seed)
        recipe = scene.value("recipe")
        hue = scene.value("main_hue")
        scene.step("pick_up, pick_up", times=3).has({"agent.newer": "none", "trial": 1})
        assert scene.value("recipe") == recipe and scene.value("main_hue") == hue
        assert len(set(dict(recipe).values() if isinstance(recipe, dict) else recipe)) == 7
        waste = zip(scene.value("water.state"), scene.value("water.hue"), strict=True)
        assert all(one == hue for state, one in waste if state != "clean")
