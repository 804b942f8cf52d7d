"""Scenes put movers where their characters are, show them there, and read their fields and places."""

from pathlib import Path

import pytest

from sjdsl.testing import Stage

STAGE = Stage(Path(__file__).parent / "meadow.sj", looks={"b": "grass grown=bare"})


def test_movers_are_put_shown_and_stepped() -> None:
    """A deer flees from the agent beside it, the other rests and is caught; both engines agree."""
    scene = STAGE.put(
        "d>d.b",
        "..#..",
        fields={"deer.rest": [5, 0], "deer.heading": ["west", "south"], "deer.fear": {1: 2}},
    )
    scene.shows("d>d.b", "..#..").has(
        {"deer.row": 0, "deer.col": [0, 2], "deer.heading": ["west", "south"], "deer.fear": [0, 2]}
    )
    assert scene.value("grass.grown")[4] == "bare"
    scene.step("stay").shows("d>.db", "..#..").has(
        {"deer.moved": [False, True], "deer.heading": ["west", "east"], "deer.fear": [0, 3]}
    )
    scene.step("turn_left").step("turn_left").shows("d<.db", "..#..")
    scene.step("catch").shows(".<.db", "..#..").has(
        {"reward": [1], "deer.away": [True, False], "deer.ticks": [2, 0], "deer.row": [None, 0]}
    )


def test_a_picture_that_is_wrong_shows_movers() -> None:
    with pytest.raises(AssertionError, match=r"d>\.\.d") as raised:
        STAGE.put("d>..d", "..#..").shows("d>.d.", "..#..")
    assert "row 0" in str(raised.value)


@pytest.mark.parametrize(
    ("picture", "message"),
    [
        (("d>...", "..#.."), "2 movers `deer`; the picture has 1 `d`"),
        (("d>ddd", "..#.."), "2 movers `deer`; the picture has 4 `d`"),
    ],
)
def test_a_picture_has_all_movers(picture: tuple[str, str], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        STAGE.put(*picture)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"looks": {"d": "grass grown=bare"}}, "stands for the movers `deer`"),
        ({"arrows": "^>vd"}, "stands for a `deer`"),
    ],
)
def test_signs_of_movers_are_taken(settings: dict, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Stage(Path(__file__).parent / "meadow.sj", **settings).put("d>d..", "..#..")


def test_movers_that_are_away_return() -> None:
    """Those in the picture may be numbered as wished; who is away is not in it."""
    scene = STAGE.put("..>.d", "..#..", movers_away={"deer": {0: 2}}).shows("..>.d", "..#..")
    scene.has({"deer.away": [True, False], "deer.ticks": [2, 0], "deer.col": [None, 4]})
    scene.step().has({"deer.ticks": [1, 0]}).step().has({"deer.away": False})
    STAGE.put("d.>.d", "..#..", numbers={"deer": [1, 0]}).has({"deer.col": [4, 0]})
    with pytest.raises(ValueError, match="no movers `dear`; did you mean `deer`"):
        STAGE.put("d.>.d", "..#..", numbers={"dear": [1, 0]})
    with pytest.raises(ValueError, match=r"are \[0, 1\] in some order, not \[1, 1\]"):
        STAGE.put("d.>.d", "..#..", numbers={"deer": [1, 1]})
    with pytest.raises(ValueError, match="no `deer` 7"):
        STAGE.put("d.>.d", "..#..", movers_away={"deer": {7: 1}})
