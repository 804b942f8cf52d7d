"""Coins, Harvest and Clean Up as released, scene by scene: beams that pass walls, and what their marks block."""

import pytest

from .environments import stage_of

FIELD = ("QQPPP", ".....", "..#..", ".....", ".....")
RIVER = ("HHHHHS", "HHHHHS", "HHH#HH", "......", "PPP.#.", "BBBBBB")
HARVEST = stage_of("harvest_open", FIELD, 3, variant="socialjax")
CLEAN_UP = stage_of("clean_up", RIVER, 3, variant="socialjax")
ORCHARD = stage_of(
    "harvest_open",
    ("QQPPP", ".....", "..A..", ".A.A.", "....."),
    2,
    variant="socialjax",
    looks={"a": "soil fruit=none"},
)


def test_zaps_pass_walls() -> None:
    """Agent 1 stands two ahead, behind the wall; agent 2 in the third place ahead is too far off."""
    scene = (
        HARVEST.put("QQ^PP  2", "..v..  1", "..#..", "..^..  0", ".....")
        .step("zap")
        .has({"event hits": [1, 0, 0], "reward": 0})
    )
    assert scene.places()[1] in {(0, 3), (0, 4)}
    assert scene.places()[2] == (0, 2)


# Pictures in which agent 0 zaps, and whom it hits. Source: the released code, commit 9df972d, played from these states
PAST_EDGES = [
    (
        ("^QPPP  0", ".....", "..#..", ".....", "v^...  12"),
        [1],
    ),  # row 0: on at the last row, in its own column alone
    (("^QPPP  0", ".....", "..#..", "v....  1", "v....  2"), [1, 2]),  # and in the row before
    (
        ("QQPPP", "^....  0", "..#..", "v....  1", "v....  2"),
        [2],
    ),  # row 1: two ahead is the last row
    (("QQPPP", ".....", "^.#..  0", "v....  1", "v....  2"), []),  # row 2: no edge
    (
        ("QQPPP", "<..^^  012", "..#..", ".....", "....."),
        [1, 2],
    ),  # column 0: on at the last two columns
    (("QQPPP", ".<.^^  012", "..#..", ".....", "....."), [2]),
    (("QQPPP", ".....", "..#..", ".....", "^^.v.  120"), [0]),  # the last row: itself
    (
        ("QQPPP", ".....", "..#..", "...v.  0", "^^...  12"),
        [],
    ),  # the row before: one ahead is the last row, twice
    (("QQPPP", "....>  0", "..#..", ".....", "^^...  12"), [0]),  # the last column: itself
]


@pytest.mark.parametrize(("picture", "hit"), PAST_EDGES)
def test_beams_go_past_the_edges(picture: tuple[str, ...], hit: list[int]) -> None:
    scene = HARVEST.put(*picture)
    before = scene.places()
    scene.step("zap").has({"event hits": [len(hit), 0, 0]})
    gates = {(0, 2), (0, 3), (0, 4)}
    assert all(
        place in gates if agent in hit else place == before[agent]
        for agent, place in enumerate(scene.places())
    )


def test_cleaning_passes_walls() -> None:
    """The cell behind the wall is cleaned with the two beside it."""
    scene = CLEAN_UP.put(
        "FFFFFS", "FFFFFS", "FFF#FF", "...^..  0", "^^P.#.", "BBBBBB", params={"pollution": 0}
    ).step("clean")
    scene.shows("FFFFFS", "FFFHFS", "FFH#HF", "...^..", "^^P.#.", "BBBBBB").has(
        {"event cleaned": [3, 0, 0]}
    )


def test_clean_water_is_counted_before_anything_else() -> None:
    """Released code: at the start of a step, before dirt falls and before anybody cleans; by default at its end."""
    picture = ("FFFFFS", "FFFFFS", "FFF#FF", "..^...  0", "^^P.#.", "BBBBBB")
    scene = (
        CLEAN_UP.put(*picture, params={"pollution": 1, "grace": 0})
        .step("clean")
        .has({"metric clean_water": 0})
    )
    after = scene.value("water.state").count("clean")
    assert after > 0
    scene.step().has({"metric clean_water": after})


def test_marks_are_seen_on_bare_cells_alone() -> None:
    """Not on ripe apples, walls and agents."""
    scene = ORCHARD.put("QQPPP", "..v..  1", "..a..", ".A^A.  0", ".....").step("zap")
    assert [scene.seen(0, "marks", ahead, right) for ahead, right in ((1, 0), (1, 1), (1, -1))] == [
        "fire",
        "fire",
        "fire",
    ]
    scene = ORCHARD.put("QQPPP", ".....", "..A..", ".A^A.  0", "..v..  1").step("zap")
    assert [scene.seen(0, "marks", ahead, right) for ahead, right in ((1, 0), (2, 0), (1, 1))] == [
        "",
        "fire",
        "fire",
    ]
    assert scene.seen(0, "content", ahead=1) == "apple"
    assert {scene.seen(0, "content", ahead=3, right=right) for right in (-2, 0, 2)} == {"floor"}
    scene = HARVEST.put("QQPPP", ".....", "..#..", "..^..  0", "vv...  12").step("zap")
    assert (scene.seen(0, "marks", ahead=1), scene.seen(0, "marks", ahead=2)) == ("", "fire")
    assert scene.seen(0, "content", ahead=1) == "outside"


# The values of the scenes below are those of the released code, commit 9df972d, played from the same states.
def test_a_marked_cell_cannot_be_entered_for_a_step() -> None:
    scene = HARVEST.put("QQPPP", ".....", "..#..", ".^...  0", "..>>.  12").step("zap")
    assert scene.step("forward").places()[0] == (3, 1)
    assert scene.step("forward").places()[0] == (2, 1)


def test_marks_of_a_beam_past_the_edge_block_too() -> None:
    scene = HARVEST.put("Q^PPP  0", ".....", "..#..", "^....  1", "...>.  2").step("zap")
    assert scene.step("stay, step_right").places()[1] == (3, 0)
    assert scene.step("stay, step_right").places()[1] == (3, 1)


@pytest.mark.parametrize(("zapper", "place"), [(0, (3, 3)), (1, (4, 3))])
def test_an_agent_with_a_higher_number_writes_the_same_cell_as_it_was(
    zapper: int, place: tuple[int, int]
) -> None:
    """The cell two ahead of one is two ahead of the other, too; agent 2 then goes there."""
    numbers = ("1", "0") if zapper == 0 else ("0", "1")
    scene = HARVEST.put(
        "QQPPP", f"...v.  {numbers[0]}", "..#..", f".>...  {numbers[1]}", "...^.  2"
    )
    scene = scene.step("zap" if zapper == 0 else "stay, zap").step("stay, stay, forward")
    assert scene.places()[2] == place


LAST_COLUMN = stage_of(
    "harvest_open",
    ("QQPPP", ".....", "...AA", "...A.", "....."),
    2,
    variant="socialjax",
    looks={"a": "soil fruit=none"},
)
SURE = {"regrow_1": 1, "regrow_2": 1, "regrow_3": 1}
NEVER = dict.fromkeys(SURE, 0)


@pytest.mark.parametrize(("row", "after"), [("...aa", "...Aa"), ("...Aa", "...AA")])
def test_the_last_column_does_not_count_the_neighbour_below_left(row: str, after: str) -> None:
    """It counts the one to the left."""
    LAST_COLUMN.put("^QPPP", ".....", row, "...A.", "....^", params=SURE).step().shows(
        "^QPPP", ".....", after, "...A.", "....^"
    )


@pytest.mark.parametrize(("numbers", "grows"), [("10", True), ("01", False)])
def test_a_tree_grows_under_a_mark_that_an_agent_with_a_higher_number_erased(
    numbers: str, grows: bool
) -> None:
    """The tree two ahead of both, one of whom zaps."""
    zapper = int(numbers[1])
    scene = ORCHARD.put(
        "QQPPP", ".....", f">.a..  {numbers[0]}", ".A.A.", f"..^..  {numbers[1]}", params=NEVER
    )
    scene.step("zap" if zapper == 0 else "stay, zap").change(**SURE).step()
    assert (scene.value("soil.fruit")[0] == "ripe") == grows


def test_nothing_grows_for_a_step_where_somebody_was_hit() -> None:
    scene = (
        ORCHARD.put("QQPPP", "..v..  0", "..^..  1", ".A.A.", ".....", params=SURE)
        .step("zap")
        .has({"event hits": [1, 0]})
    )
    assert scene.step().value("soil.fruit")[0] == "none"
    assert scene.step().value("soil.fruit")[0] == "ripe"


CLEANING = [  # agent 0 cleans, the others stay
    (("FFFFFS", "FFFFFS", "F^F#FF  0", "......", "^^P.#.", "BBBBBB"), ("FHFFFS", "HHHFFS")),
    (
        ("FFFFFS", "FFFFFS", "F^^#FF  01", "......", "^PP.#.", "BBBBBB"),
        ("FHFFFS", "HFHFFS"),
    ),  # one beside it lays its left last
    (
        ("FFFFFS", "FFFFFS", "F^F#FF  0", ".^....  1", "^PP.#.", "BBBBBB"),
        ("FHFFFS", "HFHFFS"),
    ),  # one behind it lays two ahead after one
    (
        ("<FFFFS  0", "FFFFFS", "FFF#FF", "......", "^^P.#.", "BBBBBB"),
        ("HFFFHS", "FFFFFS"),
    ),  # past the edge, on at the other
]


@pytest.mark.parametrize(("picture", "after"), CLEANING)
def test_cleaning_beside_others_and_past_the_edge(
    picture: tuple[str, ...], after: tuple[str, str]
) -> None:
    scene = CLEAN_UP.put(*picture, params={"pollution": 0}).step("clean")
    wanted = [
        "clean" if glyph == "H" else "dirty" for row in after for glyph in row if glyph in "HF"
    ]
    assert list(scene.value("water.state"))[:10] == wanted


def test_dirt_under_agents_is_not_cleaned() -> None:
    """The map has dirt where agent 1 stands."""
    stage = stage_of("clean_up", ("HHHHHS", "HFHHHS", *RIVER[2:]), 3, variant="socialjax")
    scene = stage.put(
        "HHHHHS", "HvHHHS  1", "H^H#HH  0", "......", "^PP.#.", "BBBBBB", params={"pollution": 0}
    ).step("clean")
    assert scene.value("water.state").count("dirty") == 1


def test_the_first_dirt_comes_a_step_later() -> None:
    picture = ("HHHHHS", "HHHHHS", "HHH#HH", "......", "^^^.#.", "BBBBBB")
    scene = CLEAN_UP.put(*picture, params={"pollution": 1, "grace": 0}).step()
    assert scene.value("water.state").count("dirty") == 0
    assert scene.step().value("water.state").count("dirty") == 1


def test_who_zaps_in_the_last_row_of_the_orchard_hits_itself() -> None:
    scene = CLEAN_UP.put(
        "HHHHHS", "HHHHHS", "HHH#HH", "......", "^^P.#.", "BBBvBB  0", params={"best_rate": 0}
    ).step("zap")
    assert scene.has({"event hits": [1, 0, 0]}).places()[0] == (4, 2)
