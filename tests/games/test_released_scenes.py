"""Coins, Harvest and Clean Up as released, scene by scene: moves by the compass, and beams that pass walls."""

import pytest

from sjdsl.testing import Stage

from .frames import check_moves

FIELD = ("QQPPP", ".....", "..#..", ".....", ".....")
RIVER = ("HHHHHS", "HHHHHS", "HHH#HH", "......", "PPP.#.", "BBBBBB")
COINS = Stage("coins", ("CCCCP", "CCCCC", "CCCCC", "PCCCC"), 2, variant="socialjax")
HARVEST = Stage("harvest_open", FIELD, 3, variant="socialjax")
CLEAN_UP = Stage("clean_up", RIVER, 3, variant="socialjax")
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


def test_beams_do_not_leave_the_map_nor_hit_their_owner() -> None:
    scene = HARVEST.put("^QPPP  0", ".....", "..#..", ".....", "v^...  12").step("zap").has({"event hits": 0})
    assert scene.places() == [(0, 0), (4, 0), (4, 1)]


def test_cleaning_passes_walls() -> None:
    """The cell behind the wall is cleaned with the two beside it."""
    scene = CLEAN_UP.put("FFFFFS", "FFFFFS", "FFF#FF", "...^..  0", "^^P.#.", "BBBBBB", params={"pollution": 0}).step("clean")
    scene.shows("FFFFFS", "FFFHFS", "FFH#HF", "...^..", "^^P.#.", "BBBBBB").has({"event cleaned": [3, 0, 0]})


def test_in_the_river_zaps_pass_walls_too() -> None:
    scene = CLEAN_UP.put("HHHHHS", "HHHvHS  1", "HHH#HH", "...^..  0", "^PP.#.", "BBBBBB").step("zap").has({"event hits": [1, 0, 0]})
    assert scene.places()[1] in {(4, 1), (4, 2)}
