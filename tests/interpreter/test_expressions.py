"""Every kind of expression, with values worked out by hand."""

import numpy as np
import pytest

from sjdsl.compiler import ir
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.state import Cell, default_params

from . import games as g

RW = ("red", "green", "blue")
BAG = ir.Type(kind="int", unit="count", by=(ir.Level("word", RW),))
AGENT, AGENTS = ir.AGENT, ir.AGENTS
PAY = ir.Type(kind="real", unit="reward", by=(ir.Level("word", ("coop", "defect")),) * 2)
GAME = g.game(
    rows=("..#", "..."),
    number_of_agents=3,
    agent_fields=(
        g.var("agent", "bag", BAG, start=0),
        g.var("agent", "friend", AGENT),
        g.var("agent", "foes", AGENTS),
        g.var("agent", "colour", g.word_type(*RW), start="red"),
        g.var("agent", "owed", g.REAL, start=0.5),
    ),
    fields=(g.var("world", "rounds", start=4),),
    params=(
        ir.Param(name="apple", type=g.REAL, value=0.1),
        ir.Param(name="payoff", type=PAY, value=((3, -1), (5, 1))),
        ir.Param(
            name="becomes",
            type=ir.Type(kind="word", words=RW, by=(ir.Level("word", RW),)),
            value=("green", "blue", "blue"),
        ),
    ),
    shapes=(g.line(2),),
)


@pytest.fixture
def here():
    world = g.world_of(GAME, (0, 0), (1, 1), None, headings=(1, 2, 3))
    world.agents["bag"] = [(0, 3, 1), (0, 0, 0), (2, 0, 0)]
    world.agents["friend"] = [1, None, 0]
    world.agents["foes"] = [frozenset({1, 2}), frozenset(), frozenset()]
    world.step = 6
    return g.instance(
        GAME, world, (g.ZAP, g.STAY, g.STAY), agent=0, other=1, floor=Cell(1, 0), wall=Cell(0, 2)
    )


def real(value):
    return ir.Number(type=g.REAL, value=value)


def test_reals_are_rounded_to_float32_at_every_step(here):
    tenth, fifth = real(0.1), real(0.2)
    both = evaluate(g.plus(tenth, fifth, type_=g.REAL), here)
    assert type(both) is np.float32
    assert both == np.float32(0.1) + np.float32(0.2)
    assert float(both) != 0.1 + 0.2


def test_a_quotient_is_a_real_and_an_integer_beside_a_real_is_converted(here):
    third = g.plus(g.number(1), g.number(3), fn="/", type_=g.REAL)
    assert evaluate(third, here) == np.float32(1) / np.float32(3)
    big = g.plus(g.number(2**24 + 1), real(0.0), type_=g.REAL)
    assert evaluate(big, here) == 2**24


def test_fields_parameters_and_names(here):
    assert evaluate(g.of_world("rounds"), here) == 4
    assert evaluate(g.of_agent("bag", BAG), here) == (0, 3, 1)
    assert (
        evaluate(g.of_agent("colour", g.word_type(*RW), g.of_agent("friend", AGENT)), here) == "red"
    )
    assert evaluate(ir.ParamRef(type=g.REAL, name="apple"), here) == np.float32(0.1)
    becomes = ir.ParamRef(
        type=ir.Type(kind="word", words=RW, by=(ir.Level("word", RW),)), name="becomes"
    )
    assert evaluate(g.at(becomes, "red"), here) == "green"
    assert evaluate(ir.Local(type=g.INT, name="kept"), here.binding({"kept": 9})) == 9
    assert evaluate(ir.Step(type=g.INT), here) == 6
    assert evaluate(ir.Named(type=g.INT, name="n", value=g.number(2)), here) == 2
    red = g.of_agent("colour", g.word_type(*RW))
    assert evaluate(ir.Narrowed(type=g.word_type("red", "blue"), value=red), here) == "red"
    with pytest.raises(AssertionError):
        evaluate(ir.Narrowed(type=g.word_type("blue"), value=red), here)
    assert default_params(GAME)["payoff"] == ((3, -1), (5, 1))


def test_a_field_of_nobody_is_a_mistake_but_a_guard_protects(here):
    colour = g.of_agent("colour", g.word_type(*RW), g.of_agent("friend", AGENT, g.agent("other")))
    with pytest.raises(AssertionError, match="nobody"):
        evaluate(colour, here)
    is_somebody = ir.Not(value=g.same(g.of_agent("friend", AGENT, g.agent("other")), ir.Nobody()))
    assert (
        evaluate(ir.Logic(fn="and", args=(is_somebody, g.same(colour, g.word("red")))), here)
        is False
    )


@pytest.mark.parametrize(
    ("name", "expected"),
    [("index", 0), ("heading", "east"), ("moved", False), ("away", False), ("row", 0), ("col", 0)],
)
def test_attributes_of_agents(here, name, expected):
    type_ = (
        ir.CONDITION
        if name in ("moved", "away")
        else g.word_type("north", "east")
        if name == "heading"
        else g.INT
    )
    assert evaluate(ir.Attribute(type=type_, owner=g.agent(), name=name), here) == expected


def test_comparisons_words_agents_and_members(here):
    assert evaluate(g.compare(g.number(2), "<", g.number(3)), here) is True
    assert evaluate(g.compare(g.number(2), "!=", g.number(2)), here) is False
    assert (
        evaluate(g.compare(ir.ParamRef(type=g.REAL, name="apple"), "==", real(0.1)), here) is True
    )
    assert evaluate(g.same(g.of_agent("colour", g.word_type(*RW)), g.word("red")), here) is True
    assert evaluate(g.same(g.of_agent("friend", AGENT), g.agent("other")), here) is True
    assert evaluate(g.same(g.cell("floor"), g.cell("wall")), here) is False


def test_memberships(here):
    colour, foes = g.of_agent("colour", g.word_type(*RW)), g.of_agent("foes", AGENTS)
    assert evaluate(ir.InWords(value=colour, words=("blue", "red")), here) is True
    assert evaluate(ir.InRange(value=g.number(3), low=g.number(1), high=g.number(3)), here) is True
    assert evaluate(ir.InRange(value=g.number(4), low=g.number(1), high=g.number(3)), here) is False
    assert evaluate(ir.InSet(value=g.agent("other"), container=foes), here) is True
    assert evaluate(ir.InSet(value=g.agent(), container=foes), here) is False
    assert evaluate(ir.IsEmpty(container=foes), here) is False
    assert (
        evaluate(ir.IsEmpty(container=g.of_agent("foes", AGENTS, g.agent("other"))), here) is True
    )


def test_conditions_about_actions_and_places(here):
    assert evaluate(g.chose(g.ZAP), here) is True
    assert evaluate(g.chose(g.ZAP, "other"), here) is False
    assert evaluate(ir.Unoccupied(cell=g.cell("floor")), here) is True
    assert (
        evaluate(ir.Unoccupied(cell=g.cell("floor")), here.binding({"floor": Cell(1, 1)})) is False
    )
    assert evaluate(ir.StandsOn(agent=g.agent(), kinds=("floor",)), here) is True
    assert evaluate(ir.StandsOn(agent=g.agent(), kinds=("wall",)), here) is False
    assert evaluate(ir.Truth(value=True), here) is True
    assert (
        evaluate(ir.Logic(fn="or", args=(ir.Truth(value=False), ir.Truth(value=True))), here)
        is True
    )


def test_counts_and_sums(here):
    bag = g.of_agent("bag", BAG)
    assert evaluate(ir.Count(type=g.INT, domain=g.cells("floor")), here) == 5
    others = g.agents("one", where=ir.Not(value=g.same(g.agent("one"), g.agent())))
    assert evaluate(ir.Count(type=g.INT, domain=others), here) == 2
    assert evaluate(ir.SumRow(type=g.INT, row=bag), here) == 4
    total = ir.Sum(
        type=g.INT,
        value=ir.SumRow(type=g.INT, row=g.of_agent("bag", BAG, g.agent("one"))),
        domain=g.agents("one"),
    )
    assert evaluate(total, here) == 6
    owed = ir.Sum(
        type=g.REAL, value=g.of_agent("owed", g.REAL, g.agent("one")), domain=g.agents("one")
    )
    assert evaluate(owed, here) == np.float32(1.5)


@pytest.mark.parametrize(("fn", "expected"), [("min", 3), ("max", 7)])
def test_the_least_and_the_greatest_over_a_domain(here, fn, expected):
    """Over the agents' own numbers plus bags 0 + 4, 1 + 0, 2 + 2; of none it is what stands after `otherwise`."""
    bag = ir.SumRow(type=g.INT, row=g.of_agent("bag", BAG, g.agent("one")))
    value = g.plus(ir.Attribute(type=g.INT, owner=g.agent("one"), name="index"), bag)
    for index, owned in ((1, 1), (0, 4), (2, 4)):
        only = g.compare(
            ir.Attribute(type=g.INT, owner=g.agent("one"), name="index"), "==", g.number(index)
        )
        assert (
            evaluate(
                ir.Extreme(type=g.INT, fn=fn, value=value, domain=g.agents("one", where=only)), here
            )
            == owned
        )
    assert (
        evaluate(ir.Extreme(type=g.INT, fn=fn, value=value, domain=g.agents("one")), here)
        == {"min": 1, "max": 4}[fn]
    )
    nobody = g.agents("one", where=ir.Truth(value=False))
    otherwise = g.number({"min": 3, "max": 7}[fn])
    assert (
        evaluate(
            ir.Extreme(type=g.INT, fn=fn, value=value, domain=nobody, otherwise=otherwise), here
        )
        == expected
    )
    assert evaluate(
        ir.Extreme(type=g.REAL, fn=fn, value=value, domain=nobody, otherwise=otherwise), here
    ) == np.float32(expected)


@pytest.mark.parametrize(
    ("left", "right", "expected"),
    [
        ("agent", "other", 2),
        ("other", "agent", 2),
        ("agent", "wall", 2),
        ("floor", "wall", 3),
        ("floor", "floor", 0),
    ],
)
def test_distances_go_along_rows_and_columns(here, left, right, expected):
    """Agent 0 stands on (0, 0) and agent 1 on (1, 1); `floor` is (1, 0), `wall` is (0, 2)."""
    places = {
        "agent": g.agent(),
        "other": g.agent("other"),
        "floor": g.cell("floor"),
        "wall": g.cell("wall"),
    }
    assert (
        evaluate(ir.Distance(type=g.INT, left=places[left], right=places[right]), here) == expected
    )


def test_an_agent_that_is_away_is_not_counted(here):
    from sjdsl.interpreter.state import Away

    here.world.away[2] = Away(3, None, None)
    assert evaluate(ir.Count(type=g.INT, domain=g.agents("one")), here) == 2
    assert (
        evaluate(
            ir.Attribute(type=ir.CONDITION, owner=g.agent(), name="away"),
            here.binding({"agent": 2}),
        )
        is True
    )


def test_case_of_words_and_conditions(here):
    colours = (
        ir.Arm(words=("red", "blue"), value=g.number(1)),
        ir.Arm(words=("green",), value=g.number(2)),
    )
    assert evaluate(ir.Case(type=g.INT, subject=g.word("blue"), arms=colours), here) == 1
    answers = (ir.Arm(words=("yes",), value=g.number(1)), ir.Arm(words=("no",), value=g.number(2)))
    assert (
        evaluate(
            ir.Case(type=g.INT, subject=g.compare(g.number(1), ">", g.number(2)), arms=answers),
            here,
        )
        == 2
    )


def test_mix_and_the_expected_entry(here):
    here.world.agents["bag"] = [(1, 3, 0), (0, 0, 0), (0, 0, 0)]
    mix = ir.Mix(type=ir.Type(kind="mix", words=RW), row=g.of_agent("bag", BAG))
    assert evaluate(mix, here) == (np.float32(0.25), np.float32(0.75), np.float32(0))
    by_colour = ir.ParamRef(type=ir.Type(kind="real", by=(ir.Level("word", RW),)), name="prices")
    here.world.params["prices"] = (np.float32(8), np.float32(4), np.float32(100))
    assert evaluate(g.at(by_colour, mix), here) == np.float32(5)


def test_a_table_at_two_mixes_is_the_expected_payoff(here):
    words = ("coop", "defect")
    two = ir.Type(kind="int", by=(ir.Level("word", words),))
    shares = [
        ir.Mix(type=ir.Type(kind="mix", words=words), row=ir.Local(type=two, name=name))
        for name in ("mine", "yours")
    ]
    here = here.binding({"mine": (1, 1), "yours": (3, 1)})
    payoff = g.at(g.at(ir.ParamRef(type=PAY, name="payoff"), shares[0]), shares[1])
    assert evaluate(payoff, here) == np.float32(3 * 0.375 - 0.125 + 5 * 0.375 + 0.125)


def test_event_totals(here):
    from dataclasses import replace

    here = replace(here, totals={("eaten", "red"): 2, ("eaten", "blue"): 3, ("hits", None): 7})
    assert evaluate(ir.EventTotal(type=g.INT, name="hits"), here) == 7
    assert evaluate(ir.EventTotal(type=g.INT, name="eaten"), here) == 5
    assert evaluate(ir.EventTotal(type=g.INT, name="eaten", word="blue"), here) == 3


def test_matrix_classes(here):
    def is_class(name, table):
        here.world.params["payoff"] = table
        return evaluate(ir.MatrixClass(name=name, table=ir.ParamRef(type=PAY, name="payoff")), here)

    dilemma, hunt, chicken, hawk_dove = (
        ((3, -1), (5, 1)),
        ((4, 0), (3, 1)),
        ((3, 1), (4, 0)),
        ((3, 2), (5, 0)),
    )
    taking_turns = ((3, -1), (8, 1))  # pays more than cooperating, so no prisoner's dilemma
    tables = (dilemma, hunt, chicken, hawk_dove, taking_turns)
    assert [is_class("prisoners_dilemma", t) for t in tables] == [True, False, False, False, False]
    assert [is_class("stag_hunt", t) for t in tables] == [False, True, False, False, False]
    assert [is_class("chicken", t) for t in tables] == [False, False, True, True, False]


def test_a_number_outside_its_proven_interval_is_found(here):
    small = ir.Type(kind="int", unit="count", low=0, high=3)
    with pytest.raises(AssertionError):
        evaluate(g.plus(g.number(2), g.number(2), type_=small), here)
