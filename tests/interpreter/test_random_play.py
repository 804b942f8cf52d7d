"""Long random play of a game built by hand: the invariants of every state."""

import random

from sjdsl.compiler import ir
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.state import default_params
from sjdsl.interpreter.step import reset, step
from sjdsl.interpreter.threefry import Threefry

from . import games as g

FRUIT = g.word_type("none", "ripe")
SOIL = g.kind("soil", "A", g.var("cell", "fruit", FRUIT, start="ripe"))
BEAM = ir.Shape(name="ray", lanes=(((1, -1),), ((1, 0), (2, 0)), ((1, 1),)), see_through=False, directed=True)


def orchard() -> ir.Game:
    """A small commons: growth, movement, eating, and beams that send home for three steps."""
    fruit, probability = g.of_cell("soil", "fruit", FRUIT), ir.Number(type=g.REAL, value=0.2)
    bare = ir.Logic(fn="and", args=(g.same(fruit, g.word("none")), ir.Unoccupied(cell=g.cell("soil"))))
    ripen = ir.Branch(test=probability, body=(ir.Set(target=fruit, value=g.word("ripe")),))
    grow = g.each(g.cells("soil", where=bare), ir.Chance(branches=(ripen,), stream=11))
    eat = g.each(
        g.agents(on=g.cell("soil"), where=g.same(fruit, g.word("ripe"))),
        ir.Set(target=fruit, value=g.word("none")),
        ir.Give(value=g.number(1), receiver=g.agent()),
        ir.Tally(event="eaten", receiver=g.agent()),
    )
    victims = g.agents("victim", restriction=g.near("ray", g.agent("zapper")))
    fire = g.each(
        g.agents("zapper", where=g.chose(g.ZAP, "zapper")),
        ir.Mark(shape="ray", anchor=g.agent("zapper")),
        g.each(victims, g.send(g.cells("floor"), g.agent("victim"), after=g.number(3))),
    )
    return g.game(
        ir.Tick(),
        g.phase(grow, name="grow"),
        g.phase(ir.Move(domain=g.agents(), stream=12), name="walk"),
        g.phase(eat, name="eat"),
        g.phase(fire, name="fire"),
        rows=("..AA.", ".#AA.", "....."),
        kinds=(g.kind("floor", "."), SOIL, g.kind("wall", "#", blocks=(ir.Block(what="agents"), ir.Block(what="ray")))),
        number_of_agents=5,
        shapes=(BEAM,),
        events=(ir.Event(name="eaten", per_agent=True),),
        observables=(
            ir.Observable(what="cell", kind="soil", field="fruit", type=FRUIT),
            ir.Observable(what="heading", type=g.word_type("north", "east", "south", "west")),
        ),
        episode=g.number(300),
    )


def test_three_hundred_steps_keep_every_invariant():
    game, choose = orchard(), random.Random(0)
    params = default_params(game)
    world = reset(game, params, Threefry(1, 2))
    eaten, away = 0, 0
    for number in range(300):
        before = world.cells["soil", "fruit"].count("ripe")
        actions = [choose.randrange(len(g.ACTS)) for _ in range(5)]
        world, outcome = step(game, world, actions, params, Threefry(3, number))
        places = [p for p in world.position if p is not None]
        assert len(set(places)) == len(places)
        assert all(game.rows[row][col] != "#" for row, col in places)
        assert outcome.reward == outcome.events["eaten"]
        assert world.cells["soil", "fruit"].count("ripe") >= before - sum(outcome.events["eaten"])
        assert all((place is None) == (gone is not None) for place, gone in zip(world.position, world.away, strict=True))
        picture = observe(game, world)
        assert [int(p[1, 1, 1]) for p in picture] == [int(place is not None) for place in world.position]
        eaten, away = eaten + sum(outcome.events["eaten"]), away + sum(a is not None for a in world.away)
    assert outcome.truncated
    assert eaten > 50
    assert away > 50


def test_the_same_draws_give_the_same_play():
    game = orchard()

    def play(seed: int) -> list:
        world, choose = reset(game, {}, Threefry(seed, 0)), random.Random(5)
        for number in range(40):
            actions = [choose.randrange(len(g.ACTS)) for _ in range(5)]
            world, _ = step(game, world, actions, {}, Threefry(seed, number))
        return [world.position, world.cells, world.heading]

    assert play(4) == play(4)
    assert play(4) != play(5)
