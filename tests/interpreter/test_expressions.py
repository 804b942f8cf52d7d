"""Values of expressions, worked out by hand, that no example of the manual shows."""

import numpy as np
import pytest

from sjdsl.compiler import ir
from sjdsl.compiler.ir.node import Expression
from sjdsl.interpreter.evaluate import VALUES, evaluate
from sjdsl.interpreter.state import Cell

from . import games as g

RW = ("red", "green", "blue")
BAG = ir.Type(kind="int", unit="count", by=(ir.Level("word", RW),))
AGENT = ir.AGENT
PAY = ir.Type(kind="real", unit="reward", by=(ir.Level("word", ("coop", "defect")),) * 2)
GAME = g.game(
    rows=("..#", "..."),
    number_of_agents=3,
    agent_fields=(
        g.var("agent", "bag", BAG, start=0),
        g.var("agent", "friend", AGENT),
        g.var("agent", "colour", g.word_type(*RW), start="red"),
    ),
    params=(ir.Param(name="payoff", type=PAY, value=((3, -1), (5, 1))),),
)


@pytest.fixture
def here():
    world = g.world_of(GAME, (0, 0), (1, 1), None, headings=(1, 2, 3))
    world.agents["bag"] = [(0, 3, 1), (0, 0, 0), (2, 0, 0)]
    world.agents["friend"] = [1, None, 0]
    return g.instance(GAME, world, (g.ZAP, g.STAY, g.STAY), agent=0, other=1, floor=Cell(1, 0), wall=Cell(0, 2))


def real(value):
    return ir.Number(type=g.REAL, value=value)


def test_reals_are_rounded_to_float32_at_every_step(here):
    tenth, fifth = real(0.1), real(0.2)
    both = evaluate(g.plus(tenth, fifth, type_=g.REAL), here)
    assert type(both) is np.float32
    assert both == np.float32(0.1) + np.float32(0.2)
    assert float(both) != 0.1 + 0.2


def test_rows_go_entry_by_entry_and_a_single_number_beside_each_entry(here):
    bag = g.of_agent("bag", BAG)
    assert evaluate(g.plus(bag, bag, type_=BAG), here) == (0, 6, 2)
    assert evaluate(g.plus(bag, g.number(10), fn="*", type_=BAG), here) == (0, 30, 10)


def test_a_field_of_nobody_is_a_mistake_but_a_guard_protects(here):
    colour = g.of_agent("colour", g.word_type(*RW), g.of_agent("friend", AGENT, g.agent("other")))
    with pytest.raises(AssertionError, match="nobody"):
        evaluate(colour, here)
    is_somebody = ir.Not(value=g.same(g.of_agent("friend", AGENT, g.agent("other")), ir.Nobody()))
    assert evaluate(ir.Logic(fn="and", args=(is_somebody, g.same(colour, g.word("red")))), here) is False


def test_a_table_at_two_mixes_is_the_expected_payoff(here):
    words = ("coop", "defect")
    two = ir.Type(kind="int", by=(ir.Level("word", words),))
    shares = [ir.Mix(type=ir.Type(kind="mix", words=words), row=ir.Local(type=two, name=name)) for name in ("mine", "yours")]
    here = here.binding({"mine": (1, 1), "yours": (3, 1)})
    payoff = g.at(g.at(ir.ParamRef(type=PAY, name="payoff"), shares[0]), shares[1])
    assert evaluate(payoff, here) == np.float32(3 * 0.375 - 0.125 + 5 * 0.375 + 0.125)


def test_matrix_classes(here):
    def is_class(name, table):
        here.world.params["payoff"] = table
        return evaluate(ir.MatrixClass(name=name, table=ir.ParamRef(type=PAY, name="payoff")), here)

    dilemma, hunt, chicken, hawk_dove = ((3, -1), (5, 1)), ((4, 0), (3, 1)), ((3, 1), (4, 0)), ((3, 2), (5, 0))
    taking_turns = ((3, -1), (8, 1))  # pays more than cooperating, so no prisoner's dilemma
    tables = (dilemma, hunt, chicken, hawk_dove, taking_turns)
    assert [is_class("prisoners_dilemma", t) for t in tables] == [True, False, False, False, False]
    assert [is_class("stag_hunt", t) for t in tables] == [False, True, False, False, False]
    assert [is_class("chicken", t) for t in tables] == [False, False, True, True, False]


def test_a_number_outside_its_proven_interval_is_found(here):
    small = ir.Type(kind="int", unit="count", low=0, high=3)
    with pytest.raises(AssertionError):
        evaluate(g.plus(g.number(2), g.number(2), type_=small), here)


def test_every_class_of_expression_has_a_value() -> None:
    assert set(Expression.__subclasses__()) == set(VALUES)
