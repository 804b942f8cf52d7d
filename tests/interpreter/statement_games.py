"""A small game with fields of every sort, and one step of it, for the tests of statements."""

from sjdsl.compiler import ir
from sjdsl.interpreter.state import default_params
from sjdsl.interpreter.step import step

from . import games as g

RG = ("red", "green")
COLOUR = g.word_type("none", *RG)
BAG = ir.Type(kind="int", unit="count", low=0, high=5, indexed_by=(ir.IndexSet("word", RG),))
SMALL = ir.Type(kind="int", unit="count", low=0, high=9)
SOIL = g.kind(
    "soil", "A", g.var("cell", "fruit", COLOUR, start="none"), g.var("cell", "hits", SMALL, start=0)
)
SOIL_FRUIT, SOIL_HITS = g.of_cell("soil", "fruit", COLOUR), g.of_cell("soil", "hits", SMALL)
FIELDS = (
    g.var("agent", "bag", BAG, capped=True, start=0),
    g.var("agent", "score", SMALL, start=0),
    g.var("agent", "colour", COLOUR, start="none"),
    g.var("agent", "foes", ir.AGENTS),
    g.var("agent", "friend", ir.AGENT),
    g.var("agent", "owed", g.REAL, start=0.0),
)


def small(*body, rows=("..A", "AA.", "..."), agents=2, **facts):
    return g.game(
        g.phase(*body),
        rows=rows,
        number_of_agents=agents,
        kinds=(g.kind("floor", "."), SOIL),
        agent_fields=FIELDS,
        fields=(g.var("world", "rounds", SMALL, start=0), g.var("world", "trials", BAG, start=0)),
        events=(
            ir.Event(name="eaten", per_agent=True),
            ir.Event(name="got", by=ir.IndexSet("word", RG), per_agent=True),
            ir.Event(name="shared", per_agent=False),
            ir.Event(name="seen", by=ir.IndexSet("word", RG), per_agent=False),
        ),
        shapes=(g.line(2),),
        **facts,
    )


def run(game, *places, draws=None, actions=None, headings=(), before=None):
    world = g.world_of(
        game, *(places or ((0, 0), (0, 1), (2, 0), (2, 1))[: game.agents.number]), headings=headings
    )
    if before is not None:
        before(world)
    actions = actions or (g.STAY,) * game.agents.number
    return step(game, world, actions, default_params(game), draws or g.Table())


def score(who="agent"):
    return g.of_agent("score", SMALL, g.agent(who))


def set_(target, value):
    return ir.Set(target=target, value=value)


def add(target, value):
    return ir.Add(target=target, value=value)
