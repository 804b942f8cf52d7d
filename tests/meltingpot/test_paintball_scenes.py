"""Paintball, scene by scene: paint, what stops a shot, health, flags, and who holds the hill. Source: Melting Pot's components."""

from typing import Any

import pytest

from sjdsl.testing import Scene, Stage

ROWS = ("PP..R...", "........", "..D.#...", "QQ..B..I")
EVEN = {"healing": 0, "broken": {"door": 0, "hatch": 0}}
FLAGS = Stage("paintball", ROWS, 4, params=EVEN, interpreted=True)
PAIR = Stage(
    "paintball", ("P.......", "........", "Q.......", "R......B"), 2, params=EVEN, interpreted=True
)
HILL = Stage(
    "paintball_king_of_the_hill", ("PP.GGGGG", "QQ.GGGGG"), 4, params=EVEN, interpreted=True
)
RED, BLUE = (0, 2), (1, 3)


def put(*picture: str, fields: dict[str, Any] | None = None, **facts: Any) -> Scene:
    """Returns a scene of four, even numbers red."""
    return FLAGS.put(
        *picture, fields={"agent.team": ["red", "blue", "red", "blue"], **(fields or {})}, **facts
    )


def paint(scene: Scene, hue: str) -> set[tuple[int, int]]:
    """Returns the cells of a colour."""
    cells = [
        (r, c)
        for r, row in enumerate(scene.stage.env.game.rows)
        for c, glyph in enumerate(row)
        if glyph not in "#DH"
    ]
    return {
        cell for cell, found in zip(cells, scene.value("ground.paint"), strict=True) if found == hue
    }


def test_a_short_shot_paints_three_lanes_and_ones_own_cell_a_long_one_a_line() -> None:
    scene = PAIR.put(
        "P.......", "<>......  10", "Q.......", "R......B", fields={"agent.team": ["red", "blue"]}
    ).step("spray")
    beside = {(row, col) for row in (0, 2) for col in (1, 2, 3)}
    assert paint(scene, "red") == {(1, 1), (1, 2), (1, 3), (1, 4), *beside}
    scene = PAIR.put(
        "P.......", "<>......  10", "Q.......", "R......B", fields={"agent.team": ["red", "blue"]}
    ).step("snipe")
    assert paint(scene, "red") == {(1, col) for col in range(2, 8)}
    scene.has({"allowed spray": {0: False}, "agent.cooling": [4, 0]}).step(times=3).has(
        {"allowed snipe": {0: False}}
    )
    scene.step().has({"allowed snipe": {0: True}})


def test_one_must_stand_still_for_a_long_shot() -> None:
    scene = PAIR.put(
        "P.......", "<>......  10", "Q.......", "R......B", fields={"agent.team": ["red", "blue"]}
    ).step("forward")
    scene.has({"allowed snipe": [False, True], "allowed spray": True}).step().has(
        {"allowed snipe": True}
    )


def test_who_stands_on_the_other_colour_can_only_shoot_itself_free() -> None:
    fields = {"agent.team": ["red", "blue"], "ground.paint": {(1, 1): "blue", (1, 2): "blue"}}
    scene = PAIR.put("P.......", "<>......  10", "Q.......", "R......B", fields=fields).step(
        "forward"
    )
    scene.has(
        {
            "agent.col": [2, 0],
            "agent.feet": ["stuck", "free"],
            "allowed forward": {0: False},
            "allowed turn_left": {0: False},
        }
    )
    scene.step("forward").has({"agent.col": {0: 2}}).step("spray").has({"agent.feet": "free"}).step(
        "forward"
    ).has({"agent.col": {0: 3}})


def test_a_shot_ends_at_who_it_shoots_down_and_passes_all_others() -> None:
    """Agent 1 has two points and is passed, agent 3 has one: what is behind it is not reached. One's own team is not hurt."""
    scene = put(
        "PP..R...", ">^<v....  0123", "..D.#...", "QQ..B..I", fields={"agent.health": {3: 1}}
    ).step("snipe")
    scene.has(
        {
            "agent.health": [2, 1, 2, 2],
            "agent.away": [False, False, False, True],
            "event shot": [0, 0, 0, 1],
        }
    )
    assert paint(scene, "red") == {(1, 1), (1, 2), (1, 3)}


def test_who_is_shot_is_away_for_81_steps_and_comes_back_at_its_teams_gates() -> None:
    scene = put(
        "PP..R...", ">^<v....  0123", "..D.#...", "QQ..B..I", fields={"agent.health": {3: 1}}
    ).step("snipe")
    scene.step(times=80).has({"agent.away": {3: True}}).step().has(
        {"agent.away": False, "agent.row": {3: 3}, "agent.health": {3: 2}}
    )
    assert scene.under(3) == "Q"


def test_walls_break_at_the_fifth_shot_which_goes_through() -> None:
    fields = {"barrier.health": 2}
    scene = put("PP..R...", "v......v  02", ">.D.#...  1", "QQ..B..^  3", fields=fields).step(
        "stay, snipe"
    )
    scene.has({"barrier.health": 1})
    assert (2, 3) not in paint(scene, "blue")
    assert (2, 1) in paint(scene, "blue")
    scene.step(times=4).step("stay, snipe").has({"barrier.health": 0})
    assert (2, 3) in paint(scene, "blue")
    scene.step("stay, forward").step("stay, forward").has(
        {"agent.col": {1: 2}},
    )


@pytest.mark.parametrize(
    ("ground", "start", "end"),
    [("red", 2, 3), ("clean", 1, 2), ("clean", 2, 2), ("blue", 1, 1), ("clean", 3, 3)],
)
def test_health_comes_back_by_the_ground(ground: str, start: int, end: int) -> None:
    fields = {
        "agent.team": ["red", "blue"],
        "agent.health": {0: start},
        "ground.paint": {(1, 1): ground},
    }
    scene = PAIR.put(
        "P.......", "<>......  10", "Q.......", "R......B", fields=fields, params={"healing": 1}
    ).step()
    scene.has({"agent.health": {0: end}}).step().has({"agent.health": {0: end}})


def test_a_flag_is_carried_home_and_pays_both_teams() -> None:
    """Those who are away too. The flag is back at once."""
    scene = put(
        "PP..R..<  0",
        "vv......  12",
        "..D.#...",
        "QQ..B..I",
        away={3: 50},
        fields={"agent.load": {0: "flag"}, "ground.flag": {(3, 4): "none"}},
    )
    scene.step("forward").step("forward").has({"event captured": 0, "reward": 0, "control": "red"})
    scene.step("forward").has(
        {
            "event captured": {0: 1},
            "reward": [1, -1, 1, -1],
            "agent.load": "none",
            "control": "both",
        }
    )
    scene.has({"ground.flag": {(0, 4): "red", (3, 4): "blue"}})


def test_no_capture_while_ones_own_flag_is_gone() -> None:
    fields = {"agent.load": {0: "flag", 1: "flag"}, "ground.flag": {(3, 4): "none", (0, 4): "none"}}
    scene = put("PP...<..  0", "v......v  12", "..D.#...", "QQ..B..^  3", fields=fields).step(
        "forward"
    )
    scene.has(
        {
            "reward": 0,
            "event captured": 0,
            "control": "neither",
            "agent.load": {0: "flag", 1: "flag"},
        }
    )


def test_who_is_shot_drops_the_flag_and_its_own_team_sends_it_home() -> None:
    fields = {"agent.load": {1: "flag"}, "agent.health": {1: 1}, "ground.flag": {(0, 4): "none"}}
    scene = put("PP..R...", ">.<....v  012", "..D.#...", "QQ..B..^  3", fields=fields).step("snipe")
    scene.has(
        {"ground.flag": {(1, 2): "red", (0, 4): "none"}, "agent.away": {1: True}, "control": "blue"}
    )
    scene.step("forward").has({"event returned": 0}).step("forward")
    scene.has(
        {
            "event returned": {0: 1},
            "ground.flag": {(1, 2): "none", (0, 4): "red"},
            "control": "both",
        }
    )


@pytest.mark.parametrize(("squares", "held"), [(7, False), (8, True)])
def test_four_fifths_hold_the_hill(squares: int, held: bool) -> None:
    """Of its ten squares; then all are painted, and each step pays at the cost of the others, those away too."""
    cells = [(r, c) for r in (0, 1) for c in range(3, 8)]
    fields = {
        "agent.team": ["red", "blue"] * 2,
        "ground.paint": dict.fromkeys(cells[:squares], "red"),
    }
    scene = HILL.put(
        "^^.GGGGG  02", "^Q.GGGGG  1", away={3: 40}, under={0: "P", 2: "P", 1: "Q"}, fields=fields
    ).step()
    scene.has({"reward": [1, -1, 1, -1] if held else 0, "control": "red" if held else "neither"})
    assert len(paint(scene, "red")) == (10 if held else 7)


@pytest.mark.parametrize(("lost", "control"), [(5, "blue"), (6, "neither")])
def test_the_hill_is_lost_below_half(lost: int, control: str) -> None:
    cells = [(r, c) for r in (0, 1) for c in range(3, 8)]
    colours = dict.fromkeys(cells[:lost], "red") | dict.fromkeys(cells[lost:], "blue")
    fields = {"agent.team": ["red", "blue"] * 2, "ground.paint": colours, "control": "blue"}
    scene = HILL.put(
        "^^.GGGGG  02", "^^.GGGGG  13", under={0: "P", 2: "P", 1: "Q", 3: "Q"}, fields=fields
    ).step()
    scene.has({"control": control, "reward": [-1, 1, -1, 1] if control == "blue" else 0})
