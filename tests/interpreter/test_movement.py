"""Moves of several agents together, each case on a map drawn beside it."""

import pytest

from sjdsl.compiler import ir
from sjdsl.interpreter.state import default_params
from sjdsl.interpreter.step import step

from . import games as g

ALL = g.phase(ir.Move(domain=g.agents(), stream=3), name="walk")
NORTH, EAST, SOUTH, WEST = range(4)


def run(rows, places, actions, headings=None, words=None, turn=ALL, **facts):
    game = g.game(turn, rows=rows, number_of_agents=len(places), **facts)
    world = g.world_of(game, *places, headings=headings or (EAST,) * len(places))
    world, _ = step(game, world, actions, default_params(game), g.Table(words or {}))
    return world


def spread(world):
    return [tuple(place) for place in world.position]


def test_agents_do_not_swap():
    world = run(("..",), [(0, 0), (0, 1)], [g.FORWARD] * 2, (EAST, WEST))
    assert (spread(world), world.moved) == ([(0, 0), (0, 1)], [False, False])


@pytest.mark.parametrize(("words", "winner"), [({}, 1), ({(3, 0): 0x100}, 0), ({(3, 0): 0xFF}, 1)])
def test_one_of_several_wins_a_cell(words, winner):
    world = run(("...",), [(0, 0), (0, 2)], [g.FORWARD] * 2, (EAST, WEST), words)
    assert spread(world) == [(0, 1) if winner == 0 else (0, 0), (0, 1) if winner == 1 else (0, 2)]


def test_followers_follow_and_a_blocked_leader_blocks_them():
    places, actions = [(0, 0), (0, 1), (0, 2)], [g.FORWARD] * 3
    assert spread(run(("....",), places, actions)) == [(0, 1), (0, 2), (0, 3)]
    assert spread(run(("...#",), places, actions)) == places


def test_cycles_turn():
    places = [(0, 0), (0, 1), (1, 1), (1, 0)]
    world = run(("..", ".."), places, [g.FORWARD] * 4, (EAST, SOUTH, WEST, NORTH))
    assert spread(world) == [(0, 1), (1, 1), (1, 0), (0, 0)]


def test_a_swapping_pair_holds_up_its_followers_and_gives_no_way():
    world = run(("...",), [(0, 1), (0, 2), (0, 0)], [g.FORWARD] * 3, (EAST, WEST, EAST))
    assert spread(world) == [(0, 1), (0, 2), (0, 0)]


def test_the_loser_of_a_cell_holds_up_its_follower():
    # 2 follows 0; 0 and 1 want the middle; 1 wins.
    world = run(("....",), [(0, 1), (0, 3), (0, 0)], [g.FORWARD] * 3, (EAST, WEST, EAST))
    assert spread(world) == [(0, 1), (0, 2), (0, 0)]


def test_a_winner_whose_cell_stays_taken_moves_nobody_else_in():
    # 0 stands in the middle and stays; 1 would have won against 2, but both are stopped.
    world = run(("...",), [(0, 1), (0, 0), (0, 2)], [g.STAY, g.FORWARD, g.FORWARD], (EAST, EAST, WEST))
    assert spread(world) == [(0, 1), (0, 0), (0, 2)]


def test_the_one_outranked_does_not_move_up_when_the_winner_is_stopped_by_a_swap():
    # 0 and 1 swap and stay; 2 wants the cell of 0 and stays as well.
    world = run(("...", "..."), [(0, 1), (0, 2), (1, 1)], [g.FORWARD] * 3, (EAST, WEST, NORTH))
    assert spread(world) == [(0, 1), (0, 2), (1, 1)]
