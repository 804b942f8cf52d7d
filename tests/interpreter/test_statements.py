"""Every kind of statement without draws, in a phase of its own."""

import numpy as np
import pytest

from sjdsl.compiler import ir
from sjdsl.interpreter.state import Cell
from sjdsl.interpreter.step import step

from . import games as g
from .statement_games import BAG, COLOUR, SMALL, SOIL_FRUIT, add, run, score, set_, small


def test_each_and_set():
    game = small(g.each(g.cells("soil"), set_(SOIL_FRUIT, g.word("red"))))
    world, _ = run(game)
    assert world.cells["soil", "fruit"] == ["red"] * 3


def test_everything_reads_the_start_of_the_phase():
    all_scores = ir.Sum(type=SMALL, value=score("one"), domain=g.agents("one"))
    game = small(
        g.each(
            g.agents(),
            ir.Let(name="old", value=score()),
            set_(score(), g.plus(ir.Local(type=SMALL, name="old"), g.number(1))),
        ),
        g.each(g.agents(), set_(g.of_agent("colour", COLOUR), g.word("red"))),
        g.when(
            g.compare(all_scores, "==", g.number(0)), set_(g.of_world("rounds", SMALL), g.number(1))
        ),
    )
    world, _ = run(game)
    assert world.agents["score"] == [1, 1]
    assert world.fields["rounds"] == 1


def test_two_sets_of_one_target_must_agree():
    agree = small(g.each(g.agents(), set_(g.of_world("rounds", SMALL), g.number(2))))
    assert run(agree)[0].fields["rounds"] == 2
    differ = small(g.each(g.agents(), set_(g.of_world("rounds", SMALL), g.index())))
    with pytest.raises(AssertionError, match="is set to"):
        run(differ)


def test_set_and_add_of_one_target_is_a_mistake():
    game = small(g.each(g.agents(), set_(score(), g.number(1)), add(score(), g.number(1))))
    with pytest.raises(AssertionError, match="added"):
        run(game)


def test_a_value_outside_its_range_is_a_mistake():
    game = small(g.each(g.agents(), add(score(), g.number(10))))
    with pytest.raises(AssertionError):
        run(game)


def test_adds_are_summed_and_the_range_applied_once():
    bag = g.of_agent("bag", BAG)
    game = small(
        g.each(g.agents(), add(g.at(bag, "red"), g.number(7)), add(g.at(bag, "red"), g.number(-4))),
        g.each(g.agents(), add(g.at(bag, "green"), g.number(9))),
    )
    world, _ = run(game)
    assert world.agents["bag"] == [(3, 5), (3, 5)]


def test_rows_are_set_and_added_whole():
    bag, trials = g.of_agent("bag", BAG), g.of_world("trials", BAG)

    def some(world):
        world.agents["bag"] = [(1, 2), (0, 1)]

    game = small(g.each(g.agents(), add(trials, bag), set_(bag, g.number(4))))
    world, _ = run(game, before=some)
    assert world.fields["trials"] == (1, 3)
    assert world.agents["bag"] == [(4, 4), (4, 4)]


def test_a_set_of_agents_is_set_before_it_is_added_to():
    foes = g.of_agent("foes", ir.AGENTS)

    def some(world):
        world.agents["foes"] = [frozenset({0, 1}), frozenset({0})]

    game = small(
        g.each(g.agents(where=g.is_agent(0)), set_(foes, ir.Nobody())),
        g.each(g.agents("giver"), g.each(g.agents(), add(foes, g.agent("giver")))),
    )
    world, _ = run(game, before=some)
    assert world.agents["foes"] == [frozenset({0, 1}), frozenset({0, 1})]
    only = small(
        g.each(g.agents(where=g.is_agent(0)), set_(foes, ir.Nobody()), add(foes, g.agent()))
    )
    assert run(only, before=some)[0].agents["foes"][0] == frozenset({0})


def test_agent_and_real_fields():
    game = small(
        g.each(
            g.agents(),
            set_(g.of_agent("friend", ir.AGENT), g.agent()),
            add(g.of_agent("owed", g.REAL), ir.Number(type=g.REAL, value=0.1)),
        )
    )
    world, _ = run(game)
    assert world.agents["friend"] == [0, 1]
    assert world.agents["owed"] == [np.float32(0.1)] * 2


def test_give_to_one_a_set_all_and_all_but():
    one = ir.Number(type=g.REAL, value=1.0)
    game = small(
        g.each(
            g.agents(where=g.is_agent(1)),
            ir.Give(value=one, receiver=g.agent()),
            ir.Give(value=g.number(10), receiver=None),
            ir.Give(value=g.number(100), receiver=None, but=g.agent()),
            ir.Give(value=g.number(1000), receiver=g.of_agent("foes", ir.AGENTS)),
            ir.Give(value=g.number(5000), receiver=ir.Nobody()),
        ),
        agents=3,
    )

    def some(world):
        world.agents["foes"][1] = frozenset({0, 1})

    _, outcome = run(game, before=some)
    assert outcome.reward == [1110, 1011, 110]
    assert all(type(r) is np.float32 for r in outcome.reward)


def test_tallies():
    foes = g.of_agent("foes", ir.AGENTS)
    game = small(
        g.each(
            g.agents(where=g.is_agent(1)),
            ir.Tally(event="eaten", receiver=g.agent()),
            ir.Tally(event="eaten", amount=g.number(3), receiver=foes),
            ir.Tally(event="got", word=g.word("green"), amount=g.number(2), receiver=g.agent()),
            ir.Tally(event="seen", word=g.word("red")),
        ),
        g.each(g.agents(), ir.Tally(event="shared")),
    )

    def some(world):
        world.agents["foes"][1] = frozenset({0, 1})

    _, outcome = run(game, before=some)
    assert outcome.events == {"eaten": [3, 4], "got": [[0, 0], [0, 2]], "shared": 2, "seen": [1, 0]}


def test_when_takes_the_first_branch_that_holds():
    branches = tuple(
        ir.Branch(test=g.compare(g.index(), "<", g.number(n)), body=(set_(score(), g.number(n)),))
        for n in (1, 2)
    )
    game = small(
        g.each(g.agents(), ir.When(branches=branches, otherwise=(set_(score(), g.number(7)),))),
        agents=3,
    )
    assert run(game)[0].agents["score"] == [1, 2, 7]


def test_mark_shows_the_cells_of_a_shape_and_end_ends():
    game = small(
        g.each(g.agents(where=g.is_agent(0)), ir.Mark(shape="ray", anchor=g.agent())),
        ir.End(),
        rows=("...", ".AA"),
    )
    world, outcome = run(game, (0, 1), (1, 1), headings=(1,))
    assert world.marks == [("act", 0, 2)]
    assert outcome.terminated is True
    world, _ = step(game, world, (g.STAY, g.STAY), {}, g.Table())
    assert world.marks == [("act", 0, 2)]


def test_remove_takes_an_agent_away():
    game = small(g.each(g.agents(where=g.is_agent(1)), ir.Remove(who=g.agent())))
    world, _ = run(game, (0, 0), (0, 1))
    assert world.position == [Cell(0, 0), None]
    assert world.away[1] is not None
    assert world.away[1].ticks == 0
