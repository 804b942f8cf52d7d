"""What a step refuses, what it leaves alone, and what is read of it; what statements do is told and tested in the manual."""

import numpy as np
import pytest

from sjdsl.compiler import ir
from sjdsl.interpreter.state import copied, default_params
from sjdsl.interpreter.step import read, step

from . import games as g
from .statement_games import SMALL, add, run, score, set_, small

ZAPS = (ir.Event(name="zaps", per_agent=True),)


def test_a_step_leaves_the_state_it_started_from_alone():
    game = g.game(g.phase(ir.Move(domain=g.agents(), stream=3), name="walk"), rows=("..",))
    world = g.world_of(game, (0, 0), headings=(1,))
    before = copied(world)
    after, _ = step(game, world, [g.FORWARD], {}, g.Table())
    assert world == before
    assert after != before


def test_default_params_have_the_types_of_the_language():
    words = ("a", "b")
    game = g.game(
        params=(
            ir.Param(name="apple", type=g.REAL, value=1),
            ir.Param(name="fewest", type=g.INT, value=2),
            ir.Param(name="pay", type=ir.Type(kind="real", by=(ir.Level("word", words),)), value=(0.1, 2)),
            ir.Param(name="becomes", type=ir.Type(kind="word", words=words, by=(ir.Level("word", words),)), value=("b", "b")),
        )
    )
    params = default_params(game)
    assert params == {"apple": 1, "fewest": 2, "pay": (np.float32(0.1), 2), "becomes": ("b", "b")}
    assert [type(params["apple"]), type(params["fewest"]), type(params["pay"][1])] == [np.float32, int, np.float32]


def test_checks_can_be_read():
    game = g.game(events=ZAPS)
    always = g.compare(ir.EventTotal(type=g.INT, name="zaps"), "<=", ir.Count(type=g.INT, domain=g.cells("floor")))
    assert read(game, g.world_of(game), always, {("zaps", None): 3}) is True
    assert read(game, g.world_of(game), always, {("zaps", None): 4}) is False


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
