"""Domains and shapes: who is found, with which number, and where lanes end."""

import pytest

from sjdsl.compiler import ir
from sjdsl.interpreter import members, shapes
from sjdsl.interpreter.evaluate import lanes, members_of, nearest_members
from sjdsl.interpreter.state import Cell

from . import games as g

FAN = ir.Shape(
    name="fan",
    lanes=(((1, 0), (2, 0)), ((0, -1), (1, -1)), ((0, 1), (1, 1))),
    see_through=False,
    directed=True,
)
ROUND = ir.Shape(
    name="round", lanes=(((1, 0), (0, -1), (0, 1), (-1, 0)),), see_through=True, directed=False
)
DOOR = g.kind(
    "door",
    "D",
    g.var("cell", "state", g.word_type("open", "shut"), start="shut"),
    blocks=(
        ir.Block(
            what="ray",
            condition=g.same(
                g.of_cell("door", "state", g.word_type("open", "shut")), g.word("shut")
            ),
        ),
    ),
)
FLOOR, WALL, SOIL = (
    g.kind("floor", "."),
    g.kind("wall", "#", blocks=(ir.Block(what="ray"),)),
    g.kind("soil", "A"),
)
GAME = g.game(
    rows=(".A.#", "A.D.", "...A"),
    kinds=(FLOOR, WALL, SOIL, DOOR),
    number_of_agents=4,
    agent_fields=(g.var("agent", "friend", ir.AGENT), g.var("agent", "foes", ir.AGENTS)),
    shapes=(g.line(3), g.line(3, "sight", see_through=True), FAN, ROUND),
)


def here(*places, headings=(), **names):
    return g.instance(GAME, g.world_of(GAME, *places, headings=headings), **names)


def found(domain, instance):
    return [(m.member, m.number) for m in members_of(domain, instance)]


PLACES = ((2, 0), (1, 0), (0, 0), (2, 3))


def test_cells_of_a_kind_and_of_a_group_are_numbered_in_reading_order():
    i = here(*PLACES)
    assert found(g.cells("soil"), i) == [((0, 1), 0), ((1, 0), 1), ((2, 3), 2)]
    group = ir.Domain(var=ir.Member(name="any", sort=ir.Sort("cell", ("wall", "soil"))))
    assert found(group, i) == [((0, 1), 0), ((0, 3), 1), ((1, 0), 2), ((2, 3), 3)]
    assert members.radix(group, i.board) == 4


def test_agents_on_a_kind_bind_the_cell_as_well():
    on = members_of(g.agents("one", on=g.cell("soil", "under")), here(*PLACES))
    assert [m.names for m in on] == [
        {"one": 1, "under": Cell(1, 0)},
        {"one": 3, "under": Cell(2, 3)},
    ]
    assert [m.number for m in on] == [1, 3]


def test_members_of_a_field():
    i = here(*PLACES, agent=0)
    i.world.agents["foes"][0], i.world.agents["friend"][0] = frozenset({3, 1}), 2
    foes, friend = g.of_agent("foes", ir.AGENTS), g.of_agent("friend", ir.AGENT)
    assert found(g.agents("one", restriction=ir.InAgents(value=foes)), i) == [(1, 1), (3, 3)]
    assert found(g.agents("one", restriction=ir.InAgents(value=friend)), i) == [(2, 2)]
    i.world.agents["friend"][0] = None
    assert found(g.agents("one", restriction=ir.InAgents(value=friend)), i) == []


def test_one_of_named_agents_is_one_even_if_named_twice():
    domain = g.agents("one", restriction=ir.Among(members=(g.agent("a"), g.agent("b"))))
    assert found(domain, here(*PLACES, a=3, b=1)) == [(1, 1), (3, 3)]
    assert found(domain, here(*PLACES, a=3, b=3)) == [(3, 3)]


@pytest.mark.parametrize(
    ("heading", "expected"),
    [(0, [(0, 1)]), (1, [(1, 2)]), (2, [(2, 1)]), (3, [(1, 0)])],
)
def test_lanes_turn_with_the_agent_and_end_at_the_edge_and_at_what_blocks(heading, expected):
    i = here((1, 1), (2, 0), (0, 0), (0, 2), headings=(heading,), agent=0)
    assert [s.cell for s in lanes(g.near("ray", g.agent()), i)[0]] == expected


def test_an_open_door_lets_the_lane_through():
    i = here((1, 1), (2, 0), (0, 0), (0, 2), headings=(1,), agent=0)
    i.world.cells["door", "state"] = ["open"]
    assert [s.cell for s in lanes(g.near("ray", g.agent()), i)[0]] == [(1, 2), (1, 3)]


def test_shape_cells_keep_their_numbers_when_others_are_off_the_map():
    i = here((0, 1), (2, 0), (1, 1), (0, 0), headings=(0,), agent=0)
    assert lanes(g.near("fan", g.agent()), i) == [[], [(Cell(0, 0), 2)], [(Cell(0, 2), 4)]]
    assert shapes.size(FAN) == 6


def test_cells_in_a_shape_are_numbered_by_the_shape():
    i = here((1, 1), (2, 0), (0, 0), (0, 2), agent=0)
    domain = g.cells("soil", restriction=g.near("round", g.agent()))
    assert found(domain, i) == [((0, 1), 0), ((1, 0), 1)]
    assert members.radix(domain, i.board) == 4


def test_an_undirected_shape_around_a_cell_does_not_turn():
    i = here(*PLACES, soil=Cell(1, 0))
    domain = g.cells("floor", restriction=g.near("round", g.cell("soil")))
    assert found(domain, i) == [((0, 0), 0), ((1, 1), 2), ((2, 0), 3)]


def test_agents_in_a_shape_keep_their_own_numbers():
    i = here((1, 1), (2, 0), (0, 1), (1, 0), agent=0)
    domain = g.agents("one", restriction=g.near("round", g.agent()))
    assert found(domain, i) == [(2, 2), (3, 3)]
    assert members.radix(domain, i.board) == 4


def test_the_nearest_of_each_lane():
    i = here((2, 1), (1, 1), (0, 1), (2, 2), headings=(0, 0, 0, 0), agent=0)
    by_lane = nearest_members(g.agents("one", restriction=g.near("fan", g.agent())), i)
    assert [m and m.member for m in by_lane] == [1, None, 3]
    not_1 = ir.Not(value=g.is_agent(1, "one"))
    by_lane = nearest_members(g.agents("one", restriction=g.near("fan", g.agent()), where=not_1), i)
    assert [m and m.member for m in by_lane] == [2, None, 3]
    cells = nearest_members(g.cells("soil", restriction=g.near("fan", g.agent())), i)
    assert [m and (m.member, m.number) for m in cells] == [(Cell(0, 1), 1), (Cell(1, 0), 3), None]


def test_an_agent_without_a_place_has_nothing_around_it():
    i = here(None, (1, 1), (0, 1), (2, 2), agent=0)
    assert lanes(g.near("fan", g.agent()), i) == [[], [], []]
