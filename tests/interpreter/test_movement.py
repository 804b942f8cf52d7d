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


@pytest.mark.parametrize(
    ("action", "heading", "place", "facing"),
    [
        (g.FORWARD, NORTH, (0, 1), NORTH),
        (g.FORWARD, EAST, (1, 2), EAST),
        (g.FORWARD, SOUTH, (2, 1), SOUTH),
        (g.FORWARD, WEST, (1, 0), WEST),
        (g.STEP_RIGHT, NORTH, (1, 2), NORTH),
        (g.STEP_LEFT, NORTH, (1, 0), NORTH),
        (g.STEP_RIGHT, SOUTH, (1, 0), SOUTH),
        (g.BACKWARD, EAST, (1, 0), EAST),
        (g.LEFT, NORTH, (1, 1), WEST),
        (g.RIGHT, WEST, (1, 1), NORTH),
        (g.STAY, EAST, (1, 1), EAST),
        (g.ZAP, EAST, (1, 1), EAST),
    ],
)
def test_one_agent_moves_relative_to_its_heading(action, heading, place, facing):
    world = run(("...",) * 3, [(1, 1)], [action], (heading,))
    assert (spread(world), world.heading) == ([place], [facing])
    assert world.moved == [place != (1, 1)]


@pytest.mark.parametrize(
    ("action", "place"),
    [(g.FORWARD, (0, 1)), (g.STEP_RIGHT, (1, 2)), (g.BACKWARD, (2, 1)), (g.STEP_LEFT, (1, 0))],
)
def test_compass_moves_ignore_the_heading(action, place):
    compass = ir.Agents(number=1, actions=g.ACTS, relative=False)
    world = run(("...",) * 3, [(1, 1)], [action], (SOUTH,), agents=compass)
    assert (spread(world), world.heading) == ([place], [SOUTH])


def test_walls_and_the_edge_stop():
    world = run(("#.",), [(0, 1)], [g.FORWARD], (WEST,))
    assert (spread(world), world.moved) == ([(0, 1)], [False])
    world = run(("#.",), [(0, 1)], [g.FORWARD], (EAST,))
    assert (spread(world), world.moved) == ([(0, 1)], [False])


def test_a_kind_may_block_some_agents_only():
    gate = g.kind("gate", "G", blocks=(ir.Block(what="agents", condition=g.is_agent(0)),))
    kinds = (g.kind("floor", "."), gate)
    world = run((".G.", ".G."), [(0, 0), (1, 0)], [g.FORWARD] * 2, kinds=kinds)
    assert spread(world) == [(0, 0), (1, 1)]


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
    world = run(
        ("...",), [(0, 1), (0, 0), (0, 2)], [g.STAY, g.FORWARD, g.FORWARD], (EAST, EAST, WEST)
    )
    assert spread(world) == [(0, 1), (0, 0), (0, 2)]


def test_the_one_outranked_does_not_move_up_when_the_winner_is_stopped_by_a_swap():
    # 0 and 1 swap and stay; 2 wants the cell of 0 and stays as well.
    world = run(("...", "..."), [(0, 1), (0, 2), (1, 1)], [g.FORWARD] * 3, (EAST, WEST, NORTH))
    assert spread(world) == [(0, 1), (0, 2), (1, 1)]


def test_only_the_agents_of_the_domain_move_and_turn():
    some = g.phase(ir.Move(domain=g.agents(where=g.is_agent(1)), stream=3), name="walk")
    world = run(("...", "..."), [(0, 0), (1, 0)], [g.FORWARD] * 2, turn=some)
    assert (spread(world), world.moved) == ([(0, 0), (1, 1)], [False, True])
    world = run(("...", "..."), [(0, 0), (1, 0)], [g.LEFT] * 2, turn=some)
    assert world.heading == [EAST, NORTH]


def test_nobody_moved_in_a_move_phase_without_movers():
    still = g.phase(ir.Move(domain=g.agents(where=ir.Truth(value=False)), stream=3), name="rest")
    game = g.game(ALL, still, rows=("..",))
    world, _ = step(game, g.world_of(game, (0, 0), headings=(EAST,)), [g.FORWARD], {}, g.Table())
    assert (spread(world), world.moved) == ([(0, 1)], [False])
