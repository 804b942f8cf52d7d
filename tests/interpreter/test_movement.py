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
