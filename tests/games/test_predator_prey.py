"""Predator and Prey, scene by scene and counted: who eats whom in which company, apples and acorns, grass, absence."""

from dataclasses import replace
from typing import Any

import pytest

from sjdsl.testing import Scene, Stage

from .environments import stage_of

pytestmark = pytest.mark.optimised

FIELD = (
    ".........",
    ".........",
    "..aan....",
    ".........",
    "gggg.....",
    ".........",
    ".........",
    ".........",
)
STAGE = stage_of("predator_prey", (*FIELD, "#########", "PPPPPP###", "XXXXXX###"), 6)
BRIEF = replace(STAGE, params={"absence": 20})  # 200 steps otherwise


def put(
    *field: str, under: dict[int, str] | None = None, stage: Stage = STAGE, **facts: Any
) -> Scene:
    """Returns a scene in which nothing grows; agents 0, 1 and 2 are predators, 3, 4 and 5 are prey.

    `field`: the rows above the wall, with the numbers of the agents there; the others wait below, out of everybody's company.
    """
    there = {int(number) for line in field for number in "".join(line.split()[1:])}
    prey, hunters = (
        [n for n in (3, 4, 5) if n not in there],
        [n for n in (0, 1, 2) if n not in there],
    )
    below = [(prey, "P"), (hunters, "X")]
    waiting = [
        "^" * len(who) + glyph * (6 - len(who)) + "###  " + "".join(map(str, who))
        for who, glyph in below
    ]
    stand = {n: glyph for who, glyph in below for n in who} | (under or {})
    params = {"apples": 0, "acorns": 0, **facts.pop("params", {})}
    return stage.put(*field, "#########", *waiting, under=stand, params=params, **facts)


def row(line: str, told: str, **facts: Any) -> Scene:
    """Returns a scene with agents in row 5, numbered `told`."""
    return put(*FIELD[:5], f"{line}  {told}", *FIELD[6:], **facts)


# Hunting


def test_prey_alone_is_eaten() -> None:
    scene = (
        row("..>^.....", "03")
        .step("bite")
        .has({"reward": [1, 0, 0, 0, 0, 0], "event caught": {0: 1}, "event eaten": {3: 1}})
    )
    scene.has({"agent.away": {3: True, 0: False}, "agent.resting": [5, 0, 0, 0, 0, 0]})


# where company stands, rows and columns from the prey that is bitten at (5, 3); a disc of radius 3
COMPANY = [
    ((0, 3), True),
    ((0, 4), False),
    ((2, 2), True),
    ((-2, 2), True),
    ((1, 3), False),
    ((-3, 0), True),
    ((-3, 1), False),
]


@pytest.mark.parametrize(("off", "counts"), COMPANY)
def test_prey_in_company_is_safe(off: tuple[int, int], counts: bool) -> None:
    """Within three cells; two prey are more than one predator. Source: Melting Pot."""
    place = (5 + off[0], 3 + off[1])
    rows = [list(line) for line in FIELD]
    rows[5][2], rows[5][3], rows[place[0]][place[1]] = ">", "^", "v"
    told = {5: "03"}
    told[place[0]] = told.get(place[0], "") + "4"
    picture = ["".join(line) + (f"  {told[r]}" if r in told else "") for r, line in enumerate(rows)]
    scene = put(*picture, under={4: FIELD[place[0]][place[1]]}, params={"apple": 0}).step("bite")
    scene.has(
        {
            "reward": {0: int(not counts)},
            "agent.away": {3: not counts, 4: False},
            "agent.resting": {0: 0 if counts else 5},
        }
    )


@pytest.mark.parametrize(
    ("line", "told", "eaten"),
    [
        ("..>^v<...", "0341", 2),
        (".^>^v....", "1034", 1),
        ("..>^vv...", "0345", 0),
        ("^.>^vv...", "10345", 0),
    ],
)
def test_as_many_predators_as_prey_are_enough(line: str, told: str, eaten: int) -> None:
    """Counted around the prey: all who bite find as many predators as prey there, or nobody does."""
    row(line, told).step("bite, bite").has({"reward": [int(eaten > 0), int(eaten > 1), 0, 0, 0, 0]})


def test_who_eats_an_acorn_is_no_company() -> None:
    fields = {"agent.mouth": {4: "eating"}, "agent.chews": {4: 9}}
    row("..>^v....", "034", fields=fields).step("bite").has(
        {"reward": {0: 1}, "agent.away": {3: True, 4: False}}
    )


def test_one_prey_feeds_one_predator() -> None:
    """Each now and then; the other does not rest."""
    fed = set()
    for seed in range(20):
        scene = row("..>^<....", "031", seed=seed).step("bite, bite")
        assert sorted(scene.reward) == [0, 0, 0, 0, 0, 1]
        fed.add(scene.reward.index(1))
        scene.has({"agent.resting": {scene.reward.index(1): 5, 1 - scene.reward.index(1): 0}})
    assert fed == {0, 1}


def test_predators_eat_predators_for_nothing() -> None:
    """And one who is eaten does not eat in the same step."""
    scene = (
        row("..>>^....", "013")
        .step("bite")
        .has(
            {
                "reward": 0,
                "agent.away": [False, True, False, False, False, False],
                "event caught": 0,
            }
        )
    )
    scene.has({"agent.resting": {0: 5}})
    outcomes = set()
    for seed in range(20):
        scene = row("..>>^....", "013", seed=seed).step("bite, bite")
        away = scene.value("agent.away")
        assert away[:4] in ([False, True, False, False], [False, False, False, True])
        scene.has({"reward": {0: 0, 1: int(away[3])}})
        outcomes.add(away[3])
    assert outcomes == {False, True}


def test_who_has_eaten_rests_five_steps() -> None:
    scene = (
        row("..>^.....", "03")
        .step("bite")
        .step("forward", times=5)
        .has({"agent.col": {0: 2}, "allowed forward": {0: True}})
    )
    scene.step("forward").has({"agent.col": {0: 3}})


def test_who_was_eaten_is_away_for_so_many_steps() -> None:
    """Prey come back to a nest with an empty mouth, predators to a lair."""
    fields = {"agent.mouth": {3: "holding"}}
    scene = row("..>^.....", "03", fields=fields, stage=BRIEF).step("bite").step(times=19)
    scene.has({"agent.away": {3: True}}).step()
    scene.has({"agent.away": {3: False}, "agent.row": {3: 9}, "agent.mouth": {3: "empty"}})
    scene = row("..>>.....", "01", stage=BRIEF).step("bite").step(times=20)
    scene.has({"agent.away": {1: False}, "agent.row": {1: 10}})


# Grass


def test_grass_keeps_predators_out_but_not_their_teeth() -> None:
    scene = put(*FIELD[:5], "^.^......  05", *FIELD[6:]).step(
        "forward, stay, stay, stay, stay, forward"
    )
    scene.has({"agent.row": {0: 5, 5: 4}})
    scene = put(*FIELD[:4], "^ggg.....  3", "^........  0", *FIELD[6:], under={3: "g"})
    scene.step("bite").has({"reward": {0: 1}, "agent.away": {3: True}})


# Food


def test_prey_eats_apples_and_predators_do_not() -> None:
    scene = put(*FIELD[:3], "..^^.....  30", *FIELD[4:])
    scene.step("forward, stay, stay, forward").has(
        {"reward": [0, 0, 0, 1, 0, 0], "event apples_eaten": [0, 0, 0, 1, 0, 0]}
    )
    scene.has({"tree.fruit": ["none", "ripe"], "metric apples_left": 1})


def test_an_acorn_is_worth_eighteen_and_takes_twenty_six_steps() -> None:
    """It is carried first; who eats cannot move, and has it only at the end."""
    scene = put(*FIELD[:3], "....^....  3", *FIELD[4:])
    scene.step("stay, stay, stay, forward").has(
        {"oak.fruit": "none", "agent.mouth": {3: "holding"}, "reward": 0}
    )
    scene.step("stay, stay, stay, backward").step("stay, stay, stay, bite").has(
        {"agent.mouth": {3: "eating"}, "agent.chews": {3: 26}}
    )
    scene.step("stay, stay, stay, forward", times=25).has(
        {"agent.row": {3: 3}, "agent.mouth": {3: "eating"}, "reward": 0}
    )
    scene.step("stay, stay, stay, forward").has(
        {
            "agent.row": {3: 3},
            "reward": {3: 18},
            "agent.mouth": {3: "empty"},
            "event acorns_eaten": {3: 1},
        }
    )
    scene.step("stay, stay, stay, forward").has(
        {"agent.row": {3: 2}, "agent.mouth": {3: "empty"}, "reward": 0}
    )


# Chances


# The map
