"""How agents move, in Harvest on a small map: relative to their heading, one to a cell, all at once."""

import itertools

import pytest

from sjdsl.testing import Scene, Stage

STAGE = Stage("harvest_open", ("QQPPPP", "......", "..#...", "......", "......"), 4)
EMPTY = "QQPPPP"

# heading -> where forward, step_right, backward and step_left lead, as (rows, columns)
AROUND = [(-1, 0), (0, 1), (1, 0), (0, -1)]


def put(*picture: str, seed: int = 0) -> Scene:
    return STAGE.put(EMPTY, *picture, seed=seed)


@pytest.mark.parametrize(("heading", "arrow"), list(enumerate("^>v<")))
def test_steps_are_relative_to_the_heading(heading: int, arrow: str) -> None:
    """And do not change it."""
    for number, action in enumerate(["forward", "step_right", "backward", "step_left"]):
        scene = put("......", "..#...", f"....{arrow}.  0", "^^^...  123").step(action)
        rows, cols = AROUND[(heading + number) % 4]
        assert scene.places()[0] == (3 + rows, 4 + cols)
        assert int(scene.state.heading[0]) == heading


def test_turns() -> None:
    scene = put("......", "..#...", ">>>>..", "......").step("turn_left, turn_right, stay, stay")
    scene.shows(EMPTY, "......", "..#...", "^v>>..", "......")
    scene.step("turn_left, turn_right").shows(EMPTY, "......", "..#...", "<<>>..", "......")
    scene.step("turn_left, turn_right").shows(EMPTY, "......", "..#...", "v^>>..", "......")
    scene.step("turn_left, turn_right").shows(EMPTY, "......", "..#...", ">>>>..", "......")


def test_edges_and_walls_stop() -> None:
    scene = put("......", ".>#...  0", "v.^..^  123", "......", seed=3)
    scene.step("forward, step_right, forward, step_right")
    scene.shows(EMPTY, "......", ".>#...  0", "v.^..^  123", "......")


def test_every_edge_of_the_map() -> None:
    corners = STAGE.put("^QPPP^", "......", "..#...", "......", "v....v")
    for action in ("forward", "step_left", "step_right"):
        actions = {
            "forward": ["forward"] * 4,
            "step_left": ["step_left", "stay", "stay", "step_left"],
            "step_right": ["stay", "step_right", "step_right", "stay"],
        }
        corners.step(", ".join(actions[action])).shows("^QPPP^", "......", "..#...", "......", "v....v")


def test_following_works_and_a_stopped_head_stops_all() -> None:
    put(".>>>..", "..#...", "^.....", "......").step("forward, forward, forward").shows(EMPTY, "..>>>.", "..#...", "^.....", "......")
    put("..>>>.", "..#...", "^.....", "......").step("forward, forward, stay").shows(EMPTY, "..>>>.", "..#...", "^.....", "......")
    put("...>>>", "..#...", "^.....", "......").step("forward, forward, forward").shows(EMPTY, "...>>>", "..#...", "^.....", "......")
    put("......", ">>#...", ">^....", "......").step("forward, forward, forward").shows(EMPTY, "......", ">>#...", ">^....", "......")


def test_agents_do_not_change_places() -> None:
    scene = put("......", "..#...", ".>>><.", "......")
    scene.step("forward, forward, forward, forward").shows(EMPTY, "......", "..#...", ".>>><.", "......")


def test_four_go_round() -> None:
    scene = put("...>v.  01", "..#^<.  32", "......", "......").step("forward, forward, forward, forward")
    scene.shows(EMPTY, "...^>.  30", "..#<v.  21", "......", "......")


def test_three_follow_one_another_round_a_corner() -> None:
    scene = put("...>v.  01", "..#^..  2", "......", ".....<  3").step("forward, forward, forward")
    scene.shows(EMPTY, "...^>.  20", "..#.v.  1", "......", ".....<  3")


def test_one_of_several_gets_a_cell() -> None:
    """Every one of three gets it in some run; the others stay."""
    winners = set()
    for seed in range(30):
        scene = put("....v.  0", "..#>.<  12", "......", "^.....  3", seed=seed).step("forward, forward, forward")
        start = [(1, 4), (2, 3), (2, 5), (4, 0)]
        moved = [agent for agent in range(4) if scene.places()[agent] != start[agent]]
        assert len(moved) == 1
        assert scene.places()[moved[0]] == (2, 4)
        winners.add(moved[0])
    assert winners == {0, 1, 2}


def test_the_cell_of_one_who_stays_is_not_entered() -> None:
    for action in ("stay", "turn_left", "zap"):
        scene = put("......", "..#...", "..>v..  01", "^....^  23").step(f"forward, {action}")
        assert scene.places()[:1] == [(3, 2)]


def test_all_moves_of_four_in_a_square() -> None:
    for number, actions in enumerate(itertools.product(["forward", "step_right", "stay"], repeat=4)):
        scene = put("......", "..#...", "....>v  01", "....<^  23", seed=number).step(", ".join(actions))
        assert len(set(scene.places())) == 4
