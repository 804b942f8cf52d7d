"""What agents see: planes, their labels, and windows turned with the heading."""

import numpy as np
import pytest

from sjdsl.compiler import ir
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.planes import planes
from sjdsl.interpreter.state import Away, Cell

from . import games as g

FRUIT, AGE = g.word_type("none", "ripe"), g.word_type("old", "new")
TEAM = g.word_type("red", "blue")
BAG = ir.Type(kind="int", unit="count", low=0, high=9, by=(ir.Level("word", ("raw", "cut")),))
SOIL = g.kind(
    "soil", "A", g.var("cell", "fruit", FRUIT, start="none"), g.var("cell", "age", AGE, start="old")
)
FIELDS = (g.var("agent", "team", TEAM, start="red"), g.var("agent", "bag", BAG, start=0))
HEADING = ir.Observable(what="heading", type=g.word_type("north", "east", "south", "west"))


def small(*observables, rows=("..#", ".A.", "A.."), number=2, **facts):
    kinds = (g.kind("floor", "."), SOIL, g.kind("wall", "#"))
    return g.game(
        rows=rows, kinds=kinds, number_of_agents=number, agent_fields=FIELDS, observables=observables,
        fields=(g.var("world", "season", AGE, start="new"), g.var("world", "round", start=7)), **facts,
    )  # fmt: skip


def plane(game, world, name):
    """Returns one plane of every agent as nested lists."""
    index = [p.name for p in planes(game)].index(name)
    return observe(game, world)[:, index].tolist()


def fruit(**facts):
    return ir.Observable(what="cell", kind="soil", field="fruit", type=FRUIT, **facts)


CELL_AGE = ir.Observable(what="cell", kind="soil", field="age", type=AGE)


@pytest.mark.parametrize(
    ("heading", "window"),
    [
        (0, [[1, 1, 3], [1, 2, 1], [2, 1, 1]]),
        (1, [[3, 1, 1], [1, 2, 1], [1, 1, 2]]),
        (2, [[1, 1, 2], [1, 2, 1], [3, 1, 1]]),
        (3, [[2, 1, 1], [1, 2, 1], [1, 1, 3]]),
    ],
)
def test_the_window_turns_so_that_forward_is_up(heading, window):
    game = small()
    assert (
        plane(game, g.world_of(game, (1, 1), (2, 2), headings=(heading,)), "content")[0] == window
    )


def test_visible_fields_are_multiplied_the_first_one_slowest():
    game = small(fruit(), CELL_AGE)
    assert planes(game)[0].labels == (
        "outside",
        "floor",
        "soil fruit=none age=old",
        "soil fruit=none age=new",
        "soil fruit=ripe age=old",
        "soil fruit=ripe age=new",
        "wall",
    )
    world = g.world_of(game, (1, 1), (2, 2))
    world.cells["soil", "fruit"], world.cells["soil", "age"] = ["ripe", "none"], ["old", "new"]
    assert plane(game, world, "content")[0] == [[1, 1, 6], [1, 4, 1], [3, 1, 1]]


def test_labels_replace_the_words_and_depend_on_who_looks():
    mine = g.is_agent(0)
    ripe = g.same(g.of_cell("soil", "fruit", FRUIT), g.word("ripe"))
    labels = (
        ir.Label(name="mine", condition=ir.Logic(fn="and", args=(ripe, mine))),
        ir.Label(name="theirs", condition=ripe),
        ir.Label(name="bare", condition=None),
    )
    game = small(fruit(labels=labels))
    assert planes(game)[0].labels == (
        "outside",
        "floor",
        "soil fruit=mine",
        "soil fruit=theirs",
        "soil fruit=bare",
        "wall",
    )
    world = g.world_of(game, (1, 1), (1, 0))
    world.cells["soil", "fruit"] = ["ripe", "none"]
    assert plane(game, world, "content")[0] == [[1, 1, 5], [1, 2, 1], [4, 1, 1]]
    assert plane(game, world, "content")[1] == [[0, 1, 1], [0, 1, 3], [0, 4, 1]]


def test_a_hidden_field_is_a_state_of_its_own():
    game = small(fruit(hidden_when=g.is_agent(1)))
    assert planes(game)[0].labels[2:5] == (
        "soil fruit=none",
        "soil fruit=ripe",
        "soil fruit=hidden",
    )
    world = g.world_of(game, (1, 1), (1, 0))
    assert plane(game, world, "content")[0][1][1] == 2
    assert plane(game, world, "content")[1][1][2] == 4


def test_marks_have_one_bit_for_each_marking_phase():
    mark = ir.Mark(shape="ray", anchor=g.agent())
    turns = tuple(g.phase(g.each(g.agents(), mark), name=name) for name in ("clean", "zap"))
    game = small(shapes=(g.line(1),), schedule=(turns[0], g.phase(name="rest"), turns[1]))
    assert planes(game)[2].name == "marks"
    assert (planes(game)[2].encoding, planes(game)[2].labels) == ("bits", ("clean", "zap"))
    world = g.world_of(game, (1, 1), (2, 2))
    world.marks = [("clean", 0, 1), ("zap", 0, 1), ("zap", 1, 2)]
    assert plane(game, world, "marks")[0] == [[0, 3, 0], [0, 0, 2], [0, 0, 0]]


def own(**facts):
    return ir.Observable(what="own", **facts)


def test_own_and_world_fields_fill_the_window():
    game = small(
        own(field="bag", word=ir.Entry(BAG.by[0], 1), type=BAG),
        ir.Observable(what="world", field="season", type=AGE),
        own(field="team", type=TEAM),
        ir.Observable(what="world", field="round", type=g.INT),
    )
    described = [(p.name, p.encoding, p.labels) for p in planes(game)[2:]]
    assert described == [
        ("agent.bag[cut]", "number", ()),
        ("agent.team", "word", ("red", "blue")),
        ("season", "word", ("old", "new")),
        ("round", "number", ()),
    ]
    world = g.world_of(game, (1, 1), (2, 2))
    world.agents |= {"team": ["red", "blue"], "bag": [(0, 5), (4, 3)]}
    picture = observe(game, world)
    assert picture.dtype == np.uint8
    assert (picture[0, 2:] == np.reshape((5, 0, 1, 7), (4, 1, 1))).all()
    assert (picture[1, 2:] == np.reshape((3, 1, 1, 7), (4, 1, 1))).all()


def test_fields_of_others_show_where_they_stand():
    blue = g.same(g.of_agent("team", TEAM, g.agent("other")), g.word("blue"))
    game = small(
        ir.Observable(what="other", field="team", type=TEAM, hidden_when=g.is_agent(2, "other")),
        ir.Observable(what="other", field="bag", word=ir.Entry(BAG.by[0], 0), type=BAG),
        ir.Observable(
            what="other",
            field="team",
            type=TEAM,
            labels=(ir.Label(name="b", condition=blue), ir.Label(name="a", condition=None)),
        ),
        number=3,
    )
    assert planes(game)[2].labels == ("nobody", "red", "blue")
    assert planes(game)[3].labels == ()
    assert planes(game)[4].labels == ("nobody", "b", "a")
    world = g.world_of(game, (1, 1), (0, 1), (2, 1))
    world.agents |= {"team": ["red", "blue", "red"], "bag": [(9, 0), (5, 0), (4, 0)]}
    first = observe(game, world)[0]
    assert first[2].tolist() == [[0, 2, 0], [0, 0, 0], [0, 0, 0]]
    assert first[3].tolist() == [[0, 5, 0], [0, 0, 0], [0, 4, 0]]
    assert first[4].tolist() == [[0, 1, 0], [0, 0, 0], [0, 2, 0]]


def test_who_is_away_sees_and_shows_nothing():
    game = small(HEADING, own(field="team", type=TEAM))
    world = g.world_of(game, (1, 1), None)
    world.agents["team"] = ["blue", "blue"]
    world.away[1] = Away(2, None, None)
    picture = observe(game, world)
    assert not picture[1].any()
    assert np.count_nonzero(picture[0, 1]) == 1


def test_what_an_agent_stands_on_stays_visible():
    game = small()
    world = g.world_of(game, (1, 1), (2, 2))
    assert world.position[0] == Cell(1, 1)
    assert observe(game, world)[0, :, 1, 1].tolist() == [2, 1]
