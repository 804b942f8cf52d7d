"""Boat Race, scene by scene: barriers, boarding, strokes, landing, and what a race leaves behind. Source: Melting Pot's components."""

from typing import Any

import pytest

from sjdsl.testing import Scene, Stage

ROWS = (
    "NNNN",
    ".hh.",
    "lnnl",
    "l..l",
    "~bb~",
    "~aa~",
    "~ww~",
    "~BB~",
    "l..l",
    "lssl",
    "lHHl",
    "SSSS",
    "PPPP",
)
STAGE = Stage("boat_race", ROWS, 3, params={"regrow": 0, "flail_moves": 0}, interpreted=True)
RACE, LAST = 100, 296  # steps of the race, and the one that ends it


def put(
    places: dict[int, tuple[int, int]], step: int = RACE, sign: str = "^", **facts: Any
) -> Scene:
    """Returns a scene with agents on these cells, in the middle of a race northwards; who is not told waits at the start."""
    rows, there = [list(row) for row in ROWS], {0: (12, 0), 1: (12, 1), 2: (12, 3), **places}
    for row, col in there.values():
        rows[row][col] = sign
    told = [
        ",".join(str(a) for col in range(4) for a, p in there.items() if p == (r, col))
        for r in range(len(ROWS))
    ]
    picture = [
        "".join(row) + (f"  {numbers}" if numbers else "")
        for row, numbers in zip(rows, told, strict=True)
    ]
    fields = {
        "barrier.gate": {(9, 1): "open", (9, 2): "open", (2, 1): "shut", (2, 2): "shut"},
        **facts.pop("fields", {}),
    }
    return STAGE.put(
        *picture,
        under={a: ROWS[r][c] for a, (r, c) in there.items()},
        step=step,
        fields=fields,
        **facts,
    )


def afloat(row: int = 7, **facts: Any) -> Scene:
    """Returns a scene with agents 0 and 1 in a boat."""
    return put(
        {0: (row, 1), 1: (row, 2)},
        fields={"agent.state": {0: "rowing", 1: "rowing"}, **facts.pop("fields", {})},
        **facts,
    )


def test_barriers_open_with_the_race_and_close_on_the_other_bank() -> None:
    scene = STAGE.put(
        *ROWS[:9], "lssl", "l^^l  01", "SSSS", "PPP^  2", under={2: "P"}, step=64
    ).step("forward")
    scene.has(
        {"lights": "yellow", "agent.row": {0: 10}, "barrier.gate": ["open", "open", "shut", "shut"]}
    ).step(times=5)
    scene.has({"lights": "yellow"}).step().has(
        {"lights": "green", "barrier.gate": ["shut", "shut", "open", "open"]}
    )
    scene.step("forward").has({"agent.row": {0: 9}}).step(times=224).has(
        {"lights": "green"}
    ).step().has({"lights": "red"})


def test_who_enters_a_seat_rows_and_cannot_walk() -> None:
    scene = (
        put({0: (8, 1), 1: (10, 2)})
        .has({"allowed row": False, "allowed flail": False})
        .step("forward")
    )
    scene.has(
        {
            "agent.state": ["rowing", "ashore", "ashore"],
            "event boarded": [1, 0, 0],
            "allowed forward": [False, True, True],
        }
    )
    scene.has({"allowed row": [True, False, False]}).step("row").has(
        {"agent.row": {0: 7}, "reward": 0}
    )


def test_a_boat_glides_when_both_row_at_once() -> None:
    """And then not for four steps; apples over the water are eaten by who passes."""
    scene = (
        afloat()
        .step("row, row")
        .has({"agent.row": [6, 6, 12], "agent.arms": [4, 4, 0], "dock.boat": "none", "reward": 0})
    )
    scene.step("row, row", times=4).has({"agent.row": {0: 6, 1: 6}}).step("row, row").has(
        {"agent.row": {0: 5, 1: 5}, "reward": [1, 1, 0]}
    )
    scene.has({"bunch.fruit": "none", "event eaten": [1, 1, 0]})


@pytest.mark.parametrize("moves", [0, 1])
def test_who_rows_while_the_other_flails_is_hurt(moves: int) -> None:
    """The boat moves by chance, for both alike."""
    scene = afloat(params={"flail_moves": moves}).step("row, flail")
    scene.has(
        {"reward": [-0.5, 0, 0], "event hurt": [1, 0, 0], "agent.row": {0: 7 - moves, 1: 7 - moves}}
    )
    scene.step("stay, flail").has({"reward": [0 if not moves else 1, 0 if not moves else 1, 0]})
    afloat(params={"flail_moves": 1}).step("flail, flail").has(
        {"reward": 0, "agent.row": {0: 6, 1: 6}}
    )


def test_a_boat_that_arrives_lands_its_rowers_behind_the_barrier() -> None:
    scene = afloat(5, fields={"dock.boat": "none"}).step("row, row")
    scene.has(
        {
            "agent.state": ["landed", "landed", "ashore"],
            "agent.row": [1, 1, 12],
            "event landed": [1, 1, 0],
        }
    )
    scene.has(
        {
            "dock.boat": {(4, 1): "here", (4, 2): "here", (7, 1): "none"},
            "allowed forward": True,
            "allowed row": False,
        }
    )
    scene.step("forward").has({"reward": [1, 0, 0], "agent.row": {0: 0}})


def test_after_a_race_it_goes_back_and_who_has_not_landed_is_out() -> None:
    fields = {
        "agent.state": {0: "landed", 1: "rowing"},
        "tree.fruit": "none",
        "bunch.fruit": "none",
    }
    scene = put({0: (1, 1), 1: (6, 2)}, step=LAST, fields=fields).step()
    scene.has(
        {
            "agent.away": [False, True, True],
            "agent.state": {0: "ashore"},
            "lights": "red",
            "event out_of_race": [0, 1, 1],
        }
    )
    scene.has({"bound": "north", "tree.fruit": "none"}).step()
    scene.has(
        {
            "bound": "south",
            "tree.fruit": ["none"] * 4 + ["ripe"] * 4,
            "bunch.fruit": "ripe",
            "lights": "red",
        }
    )


def test_when_all_are_out_the_episode_ends_at_the_next_hundred() -> None:
    scene = (
        put({0: (11, 1), 1: (11, 2)}, step=LAST)
        .step()
        .has({"agent.away": True, "terminated": False})
    )
    scene.step(times=3).has({"terminated": False}).step().has({"terminated": True})
