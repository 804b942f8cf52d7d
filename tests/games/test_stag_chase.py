"""Stags that Move, scene by scene: who fells a stag, whom it kicks, how it bolts and flees, and who catches hares."""

import pytest

from sjdsl.testing import Scene

from .environments import stage_of

ROWS = (".......", ".......", ".......", ".......", ".......")
STAGE = stage_of("stag_chase", ROWS, 2, params={"herd": 1, "hares": 1})


def put(*rows: str, **fields: object) -> Scene:
    return STAGE.put(
        *rows,
        fields={
            "stag.wind": "tired",
            **{name.replace("_", ".", 1): value for name, value in fields.items()},
        },
    )


@pytest.mark.parametrize(
    ("actions", "rewards"),
    [("strike, strike", [5, 5]), ("strike, stay", [-0.5, 0]), ("stay, stay", [0, 0])],
)
def test_a_stag_falls_to_two_who_strike_together(actions: str, rewards: list[float]) -> None:
    scene = put(".......", "..^S^..", ".......", ".......", "h......").step(actions)
    scene.has(
        {
            "reward": rewards,
            "event felled": int(min(rewards) > 0),
            "event hunted": [int(r > 0) for r in rewards],
        }
    )
    scene.has({"event kicked": [int(r < 0) for r in rewards]})


def test_who_is_kicked_staggers_and_the_stag_bolts_straight_on() -> None:
    scene = put(".......", ".......", "..^S...", ".......", "^.....h", stag_heading="east").step(
        "strike, stay"
    )
    assert scene.places()[0] == (2, 1)
    scene.has({"stag.bolts": 3, "stag.col": 4})
    scene.step().has({"stag.bolts": 2, "stag.col": 5}).step().has({"stag.col": 6})


@pytest.mark.parametrize(("wind", "distance"), [("fresh", 2), ("tired", 1)])
def test_a_fresh_stag_flees_from_the_hunter_it_smells(wind: str, distance: int) -> None:
    scene = put(".......", "..^S...", ".......", ".......", "h.....^", stag_wind=wind).step()
    (row, column), stag = (
        scene.places()[0],
        (scene.value("stag.row")[0], scene.value("stag.col")[0]),
    )
    assert abs(row - stag[0]) + abs(column - stag[1]) == distance


def test_anybody_catches_a_hare_alone_and_only_one_does() -> None:
    scene = put("S......", ".......", ".......", "..^h^..", ".......").step("strike, strike")
    assert sorted(scene.value("reward")) == [0, 1] and sum(scene.value("event caught")) == 1
    scene.has({"hare.away": True})
