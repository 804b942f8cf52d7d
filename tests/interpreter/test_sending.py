"""Sends: which free cell, which heading, away for a while, coming back, and staying where there is no room."""

import pytest

from sjdsl.compiler import ir
from sjdsl.interpreter.state import Away, Pool
from sjdsl.interpreter.step import step
from sjdsl.interpreter.threefry import Recorded, return_stream

from . import games as g

FLOOR, DEN = g.kind("floor", "."), g.kind("den", "Q")
FIRE = Pool("fire", 0)
ROWS = ("..Q", "..Q", "..Q")
ZAPPED = g.agents(where=g.chose(g.ZAP))


def den_game(*turns, rows=ROWS, agents=3, **facts):
    return g.game(*turns, rows=rows, kinds=(FLOOR, DEN), number_of_agents=agents, **facts)


def home(**facts):
    return g.phase(g.each(ZAPPED, g.send(g.cells("den"), **facts)), name="fire")


def run(game, places, actions=None, draws=None, headings=()):
    world = g.world_of(game, *places, headings=headings)
    return advance(game, world, actions or [g.ZAP] * len(places), draws)


def advance(game, world, actions, draws=None):
    return step(game, world, actions, {}, draws or g.Table())[0]


@pytest.mark.parametrize(("word", "heading"), [(0, 0), (0x40000000, 1), (0x80000000, 2), (g.LAST, 3)])
def test_headings_are_drawn_by_agent(word, heading):
    draws = g.Table({(2000, 1): word})
    world = run(den_game(home()), [(0, 0), (0, 1), (1, 0)], [g.STAY, g.ZAP, g.STAY], draws, headings=(3, 3, 3))
    assert world.heading == [3, heading, 3]


def test_being_sent_home_twice_is_the_same_as_once():
    zapper = g.agents("zapper", where=g.chose(g.ZAP, "zapper"))
    victims = g.agents("victim", where=g.is_agent(2, "victim"))
    fire = g.phase(g.each(zapper, g.each(victims, g.send(g.cells("den"), g.agent("victim")))), name="fire")
    world = run(den_game(fire), [(0, 0), (0, 1), (1, 0)], [g.ZAP, g.ZAP, g.STAY])
    assert world.position == [(0, 0), (0, 1), (0, 2)]


def test_two_destinations_for_one_agent_are_a_mistake():
    fire = g.phase(g.each(ZAPPED, g.send(g.cells("den")), g.send(g.cells("floor"), pool=1)), name="fire")
    with pytest.raises(AssertionError, match="two places"):
        run(den_game(fire), [(0, 0), (0, 1), (1, 0)])


def test_two_pools_have_words_each():
    fire = g.phase(
        g.each(g.agents(where=g.is_agent(0)), g.send(g.cells("den"))),
        g.each(g.agents(where=g.is_agent(1)), g.send(g.cells("floor"), pool=1)),
        name="fire",
    )
    world = run(den_game(fire), [(0, 0), (0, 1), (1, 0)], draws=g.Table({(1000, 0): g.turn(2, 3), (1001, 1): g.turn(3, 4)}))
    assert world.position == [(2, 2), (2, 1), (1, 0)]


def test_agents_take_cells_that_fit_them_in_id_order():
    """Agent 0 fits rows above 0, agent 1 rows above 1: of three cells 0 takes the first of its two, 1 the last."""
    den = ir.Attribute(type=g.INT, owner=g.cell("den"), name="row")
    lower = g.cells("den", where=g.compare(den, ">", g.index()))
    fire = g.phase(g.each(ZAPPED, g.send(lower, stay=True)), name="fire")
    draws = Recorded(g.Table({(1000, 0): g.turn(0, 2), (1000, 1): g.turn(0, 1)}))
    assert run(den_game(fire), [(0, 0), (0, 1), (1, 0)], draws=draws).position == [(1, 2), (2, 2), (1, 0)]
    assert [chosen.left for chosen in draws.chosen] == [((1, 2), (2, 2)), ((2, 2),)]
    draws = g.Table({(1000, 0): g.turn(1, 2)})  # 0 takes the only cell of 1, who stays
    assert run(den_game(fire), [(0, 0), (0, 1), (1, 0)], draws=draws).position == [(2, 2), (0, 1), (1, 0)]


def test_pools_that_share_cells_are_filled_one_after_the_other():
    fire = g.phase(
        g.each(g.agents(where=g.is_agent(1)), g.send(g.cells("den"))),
        g.each(g.agents(where=g.is_agent(0)), g.send(g.cells("den"), pool=1, stay=True)),
        name="fire",
    )
    draws = Recorded(g.Table({(1000, 1): g.turn(1, 3), (1001, 0): g.turn(1, 2)}))
    world = run(den_game(fire), [(0, 0), (0, 1), (1, 0)], [g.ZAP] * 3, draws)
    assert world.position == [(2, 2), (1, 2), (1, 0)]
    assert [len(chosen.left) for chosen in draws.chosen] == [3, 2]


def test_without_room_an_agent_stays_where_it_was_and_keeps_its_heading():
    game = den_game(home(stay=True), rows=("...", "..Q"))
    world = run(game, [(0, 0), (0, 1), (1, 0)], headings=(1, 1, 1))
    assert world.position == [(1, 2), (0, 1), (1, 0)]
    assert world.heading == [0, 1, 1]
    with pytest.raises(AssertionError, match="agent 1 is sent to den, where no cell is free"):
        run(den_game(home(), rows=("...", "..Q")), [(0, 0), (0, 1), (1, 0)])


def test_a_delay_takes_an_agent_away_until_its_tick():
    game = den_game(ir.Tick(), home(after=g.number(2)))
    world = run(game, [(0, 0), (0, 1), (1, 0)], [g.STAY, g.ZAP, g.STAY])
    assert world.position == [(0, 0), None, (1, 0)]
    assert world.away[1] == Away(2, FIRE, None)
    rest = [g.STAY] * 3
    world = advance(game, world, rest)
    assert world.away[1] == Away(1, FIRE, None)
    draws = Recorded(g.Table({(return_stream(1000), 1): g.turn(1, 3), (return_stream(2000), 1): g.LAST}))
    world = advance(game, world, rest, draws)
    assert (world.position[1], world.away[1], world.heading[1]) == ((1, 2), None, 3)
    assert {u.stream for u in draws.used} == {return_stream(1000), return_stream(2000)}


def test_two_pools_that_come_back_together_do_not_collide():
    def fire(who, pool):
        where = ir.Logic(fn="and", args=(g.chose(g.ZAP), g.is_agent(who)))
        return g.phase(g.each(g.agents(where=where), g.send(g.cells("den"), pool=pool, after=g.number(1))), name=f"f{who}")

    game = den_game(ir.Tick(), fire(0, 0), fire(1, 1), agents=2)
    world = run(game, [(0, 0), (0, 1)])
    assert advance(game, world, [g.STAY] * 2).position == [(0, 2), (1, 2)]
