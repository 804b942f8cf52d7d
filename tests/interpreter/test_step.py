"""A whole step and a reset: forbidden actions, the order of turns, timers, measures, ends."""

import numpy as np

from sjdsl.compiler import ir
from sjdsl.interpreter.state import default_params
from sjdsl.interpreter.step import action_mask, reset, step

from . import games as g

STEPS = ir.Type(kind="int", unit="steps", low=0)
RESTING = g.of_agent("resting", STEPS)
REST_FIELD = g.var("agent", "resting", STEPS, timer=True, start=0)


def forbidding(*forbids, number=2, fields=(REST_FIELD,)):
    return ir.Agents(number=number, actions=g.ACTS, relative=True, fields=fields, forbids=forbids)


def count_zaps():
    return g.phase(
        g.each(g.agents(where=g.chose(g.ZAP)), ir.Tally(event="zaps", receiver=g.agent())),
        name="count",
    )


ZAPS = (ir.Event(name="zaps", per_agent=True),)
TIRED = ir.Forbid(actions=(g.ZAP, g.FORWARD), condition=g.compare(RESTING, ">", g.number(0)))
FIRST = ir.Forbid(actions=(g.ZAP,), condition=g.is_agent(0))


def test_a_forbidden_action_becomes_stay():
    game = g.game(count_zaps(), agents=forbidding(TIRED, FIRST), number_of_agents=2, events=ZAPS)
    world = g.world_of(game)
    assert step(game, world, [g.ZAP, g.ZAP], {}, g.Table())[1].events == {"zaps": [0, 1]}
    world.agents["resting"] = [0, 1]
    assert step(game, world, [g.ZAP, g.ZAP], {}, g.Table())[1].events == {"zaps": [0, 0]}
    mask = action_mask(game, world)
    assert [[a for a, allowed in enumerate(row) if not allowed] for row in mask] == [
        [g.ZAP],
        [g.FORWARD, g.ZAP],
    ]


def test_an_unknown_action_becomes_stay():
    stays = g.phase(
        g.each(g.agents(where=g.chose(g.STAY)), ir.Tally(event="zaps", receiver=g.agent())),
        name="count",
    )
    game = g.game(stays, number_of_agents=3, events=ZAPS)
    _, outcome = step(game, g.world_of(game), [-1, 8, g.ZAP], {}, g.Table())
    assert outcome.events == {"zaps": [1, 1, 0]}


def rest_game(*turns):
    return g.game(*turns, agents=forbidding(TIRED, number=1), events=ZAPS)


def rest(n):
    return g.phase(
        g.each(g.agents(where=g.chose(g.LEFT)), ir.Set(target=RESTING, value=g.number(n))),
        name="rest",
    )


def void_steps(game):
    """Returns how many of the steps after a rest of 3 forbid the action."""
    world, _ = step(game, g.world_of(game), [g.LEFT], {}, g.Table())
    void = 0
    while not action_mask(game, world)[0][g.ZAP]:
        world, outcome = step(game, world, [g.ZAP], {}, g.Table())
        assert outcome.events == {"zaps": [0]}
        void += 1
    return void


def test_a_timer_set_after_the_tick_lasts_n_steps_and_before_it_one_less():
    assert void_steps(rest_game(ir.Tick(), rest(3), count_zaps())) == 3
    assert void_steps(rest_game(rest(3), count_zaps(), ir.Tick())) == 2


def test_every_timer_falls_but_not_below_nought():
    by = ir.Type(kind="int", unit="steps", low=0, by=(ir.Level("word", ("a", "b")),))
    soil = g.kind(
        "floor",
        ".",
        g.var("cell", "left", STEPS, timer=True),
        g.var("cell", "kept", STEPS, start=2),
    )
    game = g.game(
        ir.Tick(),
        kinds=(soil,),
        agents=forbidding(number=1),
        fields=(
            g.var("world", "clock", STEPS, timer=True),
            g.var("world", "clocks", by, timer=True),
        ),
    )
    world = g.world_of(game)
    world.cells["floor", "left"] = [0, 1, 5]
    world.fields |= {"clock": 2, "clocks": (0, 3)}
    world, _ = step(game, world, [g.STAY], {}, g.Table())
    assert world.cells == {("floor", "left"): [0, 0, 4], ("floor", "kept"): [2, 2, 2]}
    assert world.fields == {"clock": 1, "clocks": (0, 2)}


def test_phases_follow_one_another():
    rounds = g.of_world("rounds")
    double = g.phase(
        ir.Set(target=rounds, value=g.plus(rounds, g.number(2), fn="*")), name="double"
    )
    more = g.phase(ir.Set(target=rounds, value=g.plus(rounds, g.number(1))), name="more")
    for turns, expected in (((double, more), 3), ((more, double), 4)):
        game = g.game(*turns, fields=(g.var("world", "rounds", start=1),))
        assert step(game, g.world_of(game), [g.STAY], {}, g.Table())[0].fields["rounds"] == expected


def test_measures_are_read_after_the_last_phase_with_the_step_of_this_step():
    rounds = g.of_world("rounds")
    more = g.phase(ir.Set(target=rounds, value=g.plus(rounds, g.number(1))), name="more")
    measures = (
        ir.Measure(name="rounds_now", mean=True, value=rounds),
        ir.Measure(name="steps", mean=False, value=ir.Step(type=STEPS)),
    )
    game = g.game(more, fields=(g.var("world", "rounds", start=1),), measures=measures)
    world, outcome = step(game, g.world_of(game), [g.STAY], {}, g.Table())
    assert outcome.measures == {"rounds_now": 2, "steps": 0}
    assert world.step == 1


def test_the_episode_is_truncated_at_its_length_and_terminated_by_end():
    last = g.when(g.compare(ir.Step(type=STEPS), "==", g.number(1)), ir.End())
    game = g.game(g.phase(last), episode=ir.ParamRef(type=STEPS, name="length"))
    world, ends = g.world_of(game), []
    for _ in range(3):
        world, outcome = step(game, world, [g.STAY], {"length": 3}, g.Table())
        ends.append((outcome.truncated, outcome.terminated))
    assert ends == [(False, False), (False, True), (True, False)]


def test_reset_starts_from_the_declared_values_and_the_maps_own():
    fruit = g.word_type("none", "ripe")
    tree = g.kind(
        "tree", "T", g.var("cell", "fruit", fruit, start="none"), g.var("cell", "age", start=3)
    )
    start = g.phase(
        g.each(
            g.agents(),
            g.send(g.cells("floor"), facing="west"),
            ir.Set(target=RESTING, value=g.number(4)),
        ),
        ir.Give(value=g.number(5), receiver=None),
        name="start",
    )
    game = g.game(
        rows=("T.t", "..T"),
        kinds=(g.kind("floor", "."), tree),
        glyphs=(
            ir.GlyphMeaning(glyph=".", kind="floor"),
            ir.GlyphMeaning(glyph="T", kind="tree"),
            ir.GlyphMeaning(glyph="t", kind="tree", starts=(("fruit", "ripe"), ("age", 7))),
        ),
        agents=forbidding(number=2),
        start=start,
    )
    world = reset(game, default_params(game), g.Table({(1000, 0): g.LAST}))
    assert world.cells == {("tree", "fruit"): ["none", "ripe", "none"], ("tree", "age"): [3, 7, 3]}
    assert (world.position, world.heading, world.step) == ([(1, 1), (0, 1)], [3, 3], 0)
    assert (world.agents["resting"], world.moved, world.away) == (
        [4, 4],
        [False, False],
        [None, None],
    )


def test_default_params_have_the_types_of_the_language():
    words = ("a", "b")
    game = g.game(
        params=(
            ir.Param(name="apple", type=g.REAL, value=1),
            ir.Param(name="fewest", type=g.INT, value=2),
            ir.Param(
                name="pay", type=ir.Type(kind="real", by=(ir.Level("word", words),)), value=(0.1, 2)
            ),
            ir.Param(
                name="becomes",
                type=ir.Type(kind="word", words=words, by=(ir.Level("word", words),)),
                value=("b", "b"),
            ),
        )
    )
    params = default_params(game)
    assert params == {"apple": 1, "fewest": 2, "pay": (np.float32(0.1), 2), "becomes": ("b", "b")}
    assert [type(params["apple"]), type(params["fewest"]), type(params["pay"][1])] == [
        np.float32,
        int,
        np.float32,
    ]
