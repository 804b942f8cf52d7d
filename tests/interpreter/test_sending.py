"""Sends and pushes, with the words written down by hand: which free cell, which heading, coming back."""

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


def test_agents_take_free_cells_in_id_order():
    places = [(0, 0), (0, 1), (1, 0)]
    world = run(
        den_game(home()),
        places,
        draws=g.Table({(1000, 0): g.turn(1, 3), (1000, 1): g.turn(1, 2), (1000, 2): g.LAST}),
    )
    assert world.position == [(1, 2), (2, 2), (0, 2)]
    world = run(den_game(home()), places, [g.STAY, g.ZAP, g.ZAP])
    assert world.position == [(0, 0), (0, 2), (1, 2)]


@pytest.mark.parametrize(
    ("word", "heading"), [(0, 0), (0x40000000, 1), (0x80000000, 2), (g.LAST, 3)]
)
def test_headings_are_drawn_by_agent(word, heading):
    draws = g.Table({(2000, 1): word})
    world = run(
        den_game(home()),
        [(0, 0), (0, 1), (1, 0)],
        [g.STAY, g.ZAP, g.STAY],
        draws,
        headings=(3, 3, 3),
    )
    assert world.heading == [3, heading, 3]


def test_agents_take_cells_that_fit_them_in_id_order():
    """Agent 0 fits rows above 0, agent 1 rows above 1: of three cells 0 takes the first of its two, 1 the last."""
    den = ir.Attribute(type=g.INT, owner=g.cell("den"), name="row")
    lower = g.cells("den", where=g.compare(den, ">", g.index()))
    fire = g.phase(g.each(ZAPPED, g.send(lower, stay=True)), name="fire")
    draws = Recorded(g.Table({(1000, 0): g.turn(0, 2), (1000, 1): g.turn(0, 1)}))
    assert run(den_game(fire), [(0, 0), (0, 1), (1, 0)], draws=draws).position == [
        (1, 2),
        (2, 2),
        (1, 0),
    ]
    assert [chosen.left for chosen in draws.chosen] == [((1, 2), (2, 2)), ((2, 2),)]
    draws = g.Table({(1000, 0): g.turn(1, 2)})  # 0 takes the only cell of 1, who stays
    assert run(den_game(fire), [(0, 0), (0, 1), (1, 0)], draws=draws).position == [
        (2, 2),
        (0, 1),
        (1, 0),
    ]


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


def test_a_delay_takes_an_agent_away_until_its_tick():
    game = den_game(ir.Tick(), home(after=g.number(2)))
    world = run(game, [(0, 0), (0, 1), (1, 0)], [g.STAY, g.ZAP, g.STAY])
    assert world.position == [(0, 0), None, (1, 0)]
    assert world.away[1] == Away(2, FIRE, None)
    rest = [g.STAY] * 3
    world = advance(game, world, rest)
    assert world.away[1] == Away(1, FIRE, None)
    draws = Recorded(
        g.Table({(return_stream(1000), 1): g.turn(1, 3), (return_stream(2000), 1): g.LAST})
    )
    world = advance(game, world, rest, draws)
    assert (world.position[1], world.away[1], world.heading[1]) == ((1, 2), None, 3)
    assert {u.stream for u in draws.used} == {return_stream(1000), return_stream(2000)}


def test_several_come_back_in_id_order():
    game = den_game(ir.Tick(), home(after=g.number(1), facing="south"))
    world = run(game, [(0, 0), (0, 1), (1, 0)])
    assert world.position == [None] * 3
    world = advance(game, world, [g.STAY] * 3, g.Table({(return_stream(1000), 0): g.LAST}))
    assert world.position == [(2, 2), (0, 2), (1, 2)]
    assert world.heading == [2, 2, 2]


def shift(direction=None, steps=1, facing="same", stream=3000, who=None, quarters=0, other=None):
    heading = None if direction is None else g.word(direction, "north", "east", "south", "west")
    way = {"heading": heading, "quarters": quarters, "other": other}
    return ir.Shift(
        who=who or g.agent(), steps=g.number(steps), facing=facing, stream=stream, **way
    )


def blown(*places, draws=None, headings=(), **way):
    """Returns where agents are who are all sent by one statement; `F` is a fence."""
    rows = ("...F", "....", "....")
    fence = ir.Kind(name="fence", glyph="F", blocks=(ir.Block(what="agents"),))
    fire = g.phase(g.each(ZAPPED, shift(**way)), name="fire")
    game = g.game(fire, rows=rows, kinds=(FLOOR, fence), number_of_agents=len(places))
    return run(game, list(places), draws=draws, headings=headings)


def test_a_row_is_sent_together_and_stops_where_its_first_stops():
    assert blown((1, 0), (1, 1), (2, 3), direction="east").position == [(1, 1), (1, 2), (2, 3)]
    assert blown((2, 2), (2, 3), (2, 0), direction="east").position == [(2, 2), (2, 3), (2, 1)]
    assert blown((0, 1), (0, 2), (2, 0), direction="east").position == [(0, 1), (0, 2), (2, 1)]


def test_the_way_must_be_open_and_empty():
    assert blown((1, 0), direction="east", steps=3).position == [(1, 3)]
    assert blown((0, 0), direction="east", steps=3).position == [(0, 0)]
    assert blown((1, 0), (1, 1), direction="east", steps=2).position == [(1, 0), (1, 3)]
    assert blown((1, 0), direction="east", steps=0, facing="south").heading == [0]
    assert blown((1, 0), direction="east", facing="south").heading == [2]
    assert blown((1, 0), direction="west", facing="south").heading == [0]


EQUALLY_FAR = [((0, 0), (1, 1), {(0, 1), (1, 0)}), ((2, 2), (1, 1), {(1, 2), (2, 1)})]


@pytest.mark.parametrize("heading", range(4))
@pytest.mark.parametrize(
    ("place", "goal", "wanted"),
    [((2, 0), (1, 2), {(2, 1)}), ((0, 1), (2, 2), {(1, 1)}), *EQUALLY_FAR],
)
def test_toward_an_agent_along_the_longer_distance(place, goal, wanted, heading):
    """Agent 0 is sent toward agent 1; where both distances are equal, along the line in which it looks."""
    toward = g.each(
        g.agents(where=g.is_agent(0)),
        g.each(g.agents("b", where=g.is_agent(1, "b")), shift(other=g.agent("b"))),
    )
    game = g.game(g.phase(toward), rows=("...", "...", "..."), kinds=(FLOOR,), number_of_agents=2)
    world = run(game, [place, goal], headings=(heading, 0))
    assert world.position[0] in wanted
    if len(wanted) == 2:
        assert (world.position[0][1] == place[1]) == (heading in (0, 2))


def test_of_two_sent_to_one_cell_the_larger_rank_enters():
    """One from the north and one from the south, by two statements."""
    for first, second, wanted in ((g.LAST, 0, [(1, 1), (2, 1)]), (0, g.LAST, [(0, 1), (1, 1)])):
        fire = g.phase(
            g.each(g.agents(where=g.is_agent(0)), shift("south")),
            g.each(g.agents(where=g.is_agent(1)), shift("north", stream=3001)),
            name="fire",
        )
        game = g.game(fire, rows=("...", "...", "..."), kinds=(FLOOR,), number_of_agents=2)
        assert (
            run(
                game, [(0, 1), (2, 1)], draws=g.Table({(3000, 0): first, (3001, 1): second})
            ).position
            == wanted
        )
