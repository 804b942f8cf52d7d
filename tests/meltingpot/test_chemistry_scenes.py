"""Chemistry, scene by scene, on the interpreter: what reacts with what, what that leaves, who is paid. Source: Melting Pot's grid of molecules."""

from collections import Counter
from typing import Any

import numpy as np
import pytest

import sjdsl
from sjdsl.testing import Scene, Stage

FOOD = ("food1", "food2", "food3")
CLASSES = {
    "a": "high",
    "b": "high",
    "c": "high",
    "damp": "high",
    "waste": "medium",
    "food": "medium",
    "lure": "medium",
    "energy": "low",
}
LOOKS = {
    **{"X": "dish mol=x", "Y": "dish mol=y", "i": "dish mol=ix", "j": "dish mol=iy"},
    **{"f": "dish mol=food1", "g": "dish mol=food2", "k": "dish mol=food3"},
}
STAGE = Stage("chemistry", ("~~~~~", "~~~~~", "~~~~~"), 1, looks=LOOKS, interpreted=True)


def put(
    *picture: str,
    seed: int = 0,
    ground: str = "",
    carried: str = "",
    fields: dict[str, Any] | None = None,
) -> Scene:
    """Returns a scene in which molecules of one sort surely react, on the ground or carried, and no others."""
    rates = {
        table: {c: float(CLASSES.get(sort) == c) for c in set(CLASSES.values())}
        for table, sort in (("ground", ground), ("carried", carried))
    }
    for table in rates.values():
        table["background"] = 0.0
    return STAGE.put(*picture, seed=seed, fields=fields, params=rates)


def counted(scene: Scene) -> Counter[str]:
    return Counter(m for m in scene.value("dish.mol") if m != "empty")


@pytest.mark.parametrize(
    ("first", "second", "ring"), [("a", "b", "x"), ("1", "2", "y"), ("4", "5", "z")]
)
def test_a_ring_makes_food(first: str, second: str, ring: str) -> None:
    """a, b and an empty cell become b, c and food, each in its place; for one step they are hot."""
    scene = put("~~~~^", f"~{first}{second}~~", "~~~~~", ground="a").step()
    assert counted(scene) == Counter({"hot": 3})
    scene.step()
    assert counted(scene) == Counter(
        {f"{ring}b": 1, f"{ring}c": 1, dict(zip("xyz", FOOD, strict=True))[ring]: 1}
    )
    assert scene.value("dish.mol")[6:8] == [f"{ring}b", f"{ring}c"]


@pytest.mark.parametrize(
    ("second", "third", "ring", "left"),
    [("b", "c", "x", 1), ("2", "3", "y", 1), ("5", "6", "z", 0)],
)
def test_a_ring_needs_energy(second: str, third: str, ring: str, left: int) -> None:
    """b, c and energy become c, a and energy; the third ring uses it up."""
    scene = put("~~~~^", f"~{second}{third}~~", "~~~~~", ground="b").step("", 2)
    assert counted(scene) == Counter({f"{ring}b": 1, f"{ring}c": 1})
    scene = put("~h~~^", f"~{second}{third}~~", "~~~~~", ground="b").step("", 2)
    assert counted(scene) == Counter(
        {f"{ring}c": 1, f"{ring}a": 1} | ({"energy": 1} if left else {})
    )


@pytest.mark.parametrize(
    ("third", "first", "made"),
    [("c", "a", ("x", "iy")), ("3", "1", ("y", "ix")), ("6", "4", ("food1", "food2"))],
)
def test_a_ring_leaves_waste(third: str, first: str, made: tuple[str, str]) -> None:
    scene = put("~~~~^", f"~{third}{first}~~", "~~~~~", ground="c").step("", 2)
    found = counted(scene)
    assert found[made[0]] == found[made[1]] == 1
    assert sum(found.values()) == 4


@pytest.mark.parametrize(
    ("pair", "sort", "left"),
    [
        *(
            ("XY", "waste", {"energy": 2}),
            ("Xi", "waste", {}),
            ("Xi", "damp", {}),
            ("Xj", "waste", {"x": 1, "iy": 1}),
        ),
        *(("ii", "damp", {}), ("ij", "damp", {"ix": 1, "iy": 1}), ("XX", "waste", {"x": 2})),
    ],
)
def test_waste_and_damp(pair: str, sort: str, left: dict[str, int]) -> None:
    assert counted(put("~~~~^", f"~{pair}~~", "~~~~~", ground=sort).step("", 2)) == Counter(left)


@pytest.mark.parametrize(("sign", "sort"), [("f", "food"), ("h", "energy"), ("x", "lure")])
def test_what_is_lost_by_itself(sign: str, sort: str) -> None:
    scene = put("~~~~^", f"~{sign}~~~", "~~~~~", ground=sort).step("", 2)
    assert counted(scene) == Counter({"lure": 1} if sort == "lure" else {})


@pytest.mark.parametrize(("food", "pay"), [("food1", 1), ("food2", 1), ("food3", 10)])
def test_carried_food_is_digested_and_pays(food: str, pay: int) -> None:
    scene = put("~~~~~", "~~^~~", "~~~~~", carried="food", fields={"agent.mol": [food]})
    scene.step().has(
        {"agent.mol": "hot", "reward": 0, "allowed forward": False, "allowed exchange": False}
    )
    scene.step("forward").has({"agent.mol": "empty", "reward": pay, "allowed forward": True})
    assert scene.places() == [(1, 2)]


def test_food_on_the_ground_goes_first_and_pays_nobody() -> None:
    carrying = {"agent.mol": ["food1"]}
    scene = put("~~~~~", "~f^f~", "~~~~~", carried="food", fields=carrying).step()
    assert counted(scene) == Counter({"hot": 1, "food1": 1})
    scene.step().has({"agent.mol": "food1", "reward": 0})
    put("~~~~~", "~g^~~", "~~~~~", carried="food", fields=carrying).step("", 2).has(
        {"agent.mol": "empty", "reward": 1}
    )


def test_who_carries_waste_is_paid_for_energy() -> None:
    carrying = {"agent.mol": ["x"]}
    scene = (
        put("~~~~~", "~~^Y~", "~~~~~", carried="waste", fields=carrying)
        .step("", 2)
        .has({"agent.mol": "energy", "reward": 10})
    )
    assert counted(scene) == Counter({"energy": 1})
    put("~~~~~", "~X^Y~", "~~~~~", carried="waste", fields=carrying).step("", 2).has(
        {"agent.mol": "x", "reward": 0}
    )


def test_exchange_with_the_ground() -> None:
    """Two steps of pause, and what has just changed cannot be taken up."""
    scene = (
        put("~~~~~", "~~^~~", "~~~~~", fields={"agent.mol": ["food3"]})
        .step("exchange")
        .has({"agent.mol": "empty"})
    )
    assert scene.value("dish.mol")[7] == "food3"
    for allowed in (False, False, True):
        scene.has({"allowed exchange": allowed}).step("exchange" if allowed else "stay")
    scene.has({"agent.mol": "food3"})


def test_rates_are_those_of_melting_pot() -> None:
    """Source: the reactivity levels of its four configurations, which are the same in all."""
    ground = {"background": 0.00001, "low": 0.005, "medium": 0.001, "high": 0.9}
    carried = {"background": 0, "low": 0.0025, "medium": 0.25, "high": 0.9}
    for variant in (None, "two", "two_distractors", "distractors"):
        params = sjdsl.make("chemistry", variant=variant).params
        for found, wanted in ((params.ground, ground), (params.carried, carried)):
            assert np.asarray(found) == pytest.approx(list(wanted.values()), rel=1e-6)
