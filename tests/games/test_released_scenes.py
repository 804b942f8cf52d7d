"""Coins, Harvest and Clean Up as released, scene by scene: moves by the compass, and beams that pass walls."""

import pytest

from sjdsl.testing import Stage

from .environments import BRIEFLY
from .frames import check_moves

FIELD = ("QQPPP", ".....", "..#..", ".....", ".....")
RIVER = ("HHHHHS", "HHHHHS", "HHH#HH", "......", "PPP.#.", "BBBBBB")
COINS = Stage("coins", ("CCCCP", "CCCCC", "CCCCC", "PCCCC"), 2, variant="socialjax", interpreted=BRIEFLY)
HARVEST = Stage("harvest_open", FIELD, 3, variant="socialjax", interpreted=BRIEFLY)
CLEAN_UP = Stage("clean_up", RIVER, 3, variant="socialjax", interpreted=BRIEFLY)
ORCHARD = Stage(
    "harvest_open",
    ("QQPPP", ".....", "..A..", ".A.A.", "....."),
    2,
    variant="socialjax",
    looks={"a": "soil fruit=none"},
    interpreted=BRIEFLY,
)
MOVES = [  # agent 0 with room around it
    (COINS, ("CCCCP", "CC^CC", "CCCCC", "PCCC<")),
    (HARVEST, ("QQPvv", ".....", "..#..", ".^...  0", ".....")),
    (CLEAN_UP, (*RIVER[:3], "..^...  0", *RIVER[4:5], "BB<<BB")),
]
NAMES = ["coins", "harvest", "clean_up"]


@pytest.mark.parametrize(("stage", "picture"), MOVES, ids=NAMES)
def test_moves_go_by_the_compass(stage: Stage, picture: tuple[str, ...]) -> None:
    check_moves(stage, picture, compass=True)


def test_zaps_pass_walls() -> None:
    """Agent 1 stands two ahead, behind the wall; agent 2 in the third place ahead is too far off."""
    scene = HARVEST.put("QQ^PP  2", "..v..  1", "..#..", "..^..  0", ".....").step("zap").has({"event hits": [1, 0, 0], "reward": 0})
    assert scene.places()[1] in {(0, 3), (0, 4)}
    assert scene.places()[2] == (0, 2)


# Pictures in which agent 0 zaps, and whom it hits. Source: the released code, commit 9df972d, played from these states
PAST_EDGES = [
    (("^QPPP  0", ".....", "..#..", ".....", "v^...  12"), [1]),  # row 0: on at the last row, in its own column alone
    (("^QPPP  0", ".....", "..#..", "v....  1", "v....  2"), [1, 2]),  # and in the row before
    (("QQPPP", "^....  0", "..#..", "v....  1", "v....  2"), [2]),  # row 1: two ahead is the last row
    (("QQPPP", ".....", "^.#..  0", "v....  1", "v....  2"), []),  # row 2: no edge
    (("QQPPP", "<..^^  012", "..#..", ".....", "....."), [1, 2]),  # column 0: on at the last two columns
    (("QQPPP", ".<.^^  012", "..#..", ".....", "....."), [2]),
    (("QQPPP", ".....", "..#..", ".....", "^^.v.  120"), [0]),  # the last row: itself
    (("QQPPP", ".....", "..#..", "...v.  0", "^^...  12"), []),  # the row before: one ahead is the last row, twice
    (("QQPPP", "....>  0", "..#..", ".....", "^^...  12"), [0]),  # the last column: itself
]


@pytest.mark.parametrize(("picture", "hit"), PAST_EDGES)
def test_beams_go_past_the_edges(picture: tuple[str, ...], hit: list[int]) -> None:
    scene = HARVEST.put(*picture)
    before = scene.places()
    scene.step("zap").has({"event hits": [len(hit), 0, 0]})
    gates = {(0, 2), (0, 3), (0, 4)}
    assert all(place in gates if agent in hit else place == before[agent] for agent, place in enumerate(scene.places()))


def test_cleaning_passes_walls() -> None:
    """The cell behind the wall is cleaned with the two beside it."""
    scene = CLEAN_UP.put("FFFFFS", "FFFFFS", "FFF#FF", "...^..  0", "^^P.#.", "BBBBBB", params={"pollution": 0}).step("clean")
    scene.shows("FFFFFS", "FFFHFS", "FFH#HF", "...^..", "^^P.#.", "BBBBBB").has({"event cleaned": [3, 0, 0]})


def test_clean_water_is_counted_before_anything_else() -> None:
    """Released code: at the start of a step, before dirt falls and before anybody cleans; by default at its end."""
    picture = ("FFFFFS", "FFFFFS", "FFF#FF", "..^...  0", "^^P.#.", "BBBBBB")
    scene = CLEAN_UP.put(*picture, params={"pollution": 1, "grace": 0}).step("clean").has({"metric clean_water": 0})
    after = scene.value("water.state").count("clean")
    assert after > 0
    scene.step().has({"metric clean_water": after})


def test_marks_are_seen_on_bare_cells_alone() -> None:
    """Not on ripe apples, walls and agents."""
    scene = ORCHARD.put("QQPPP", "..v..  1", "..a..", ".A^A.  0", ".....").step("zap")
    assert [scene.seen(0, "marks", ahead, right) for ahead, right in ((1, 0), (1, 1), (1, -1))] == ["fire", "fire", "fire"]
    scene = ORCHARD.put("QQPPP", ".....", "..A..", ".A^A.  0", "..v..  1").step("zap")
    assert [scene.seen(0, "marks", ahead, right) for ahead, right in ((1, 0), (2, 0), (1, 1))] == ["", "fire", "fire"]
    assert scene.seen(0, "content", ahead=1) == "apple"
    assert {scene.seen(0, "content", ahead=3, right=right) for right in (-2, 0, 2)} == {"floor"}
    scene = HARVEST.put("QQPPP", ".....", "..#..", "..^..  0", "vv...  12").step("zap")
    assert (scene.seen(0, "marks", ahead=1), scene.seen(0, "marks", ahead=2)) == ("", "fire")
    assert scene.seen(0, "content", ahead=1) == "outside"


def test_in_the_river_zaps_pass_walls_too() -> None:
    scene = CLEAN_UP.put("HHHHHS", "HHHvHS  1", "HHH#HH", "...^..  0", "^PP.#.", "BBBBBB").step("zap").has({"event hits": [1, 0, 0]})
    assert scene.places()[1] in {(4, 1), (4, 2)}
