"""Small games built by hand, node by node, for the interpreter's tests."""

from dataclasses import dataclass, field

from sjdsl.compiler import ir
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import Cell, World, copied, default_params
from sjdsl.interpreter.step import reset

INT = ir.Type(kind="int", unit="count")
REAL = ir.Type(kind="real", unit="number")
ACTS = ("turn_left", "turn_right", "step_left", "step_right", "forward", "backward", "stay", "zap")
LEFT, RIGHT, STEP_LEFT, STEP_RIGHT, FORWARD, BACKWARD, STAY, ZAP = range(8)
LAST = 0xFFFFFFFF


@dataclass
class Table:
    """Draws written down by a test; every word it does not name is `rest`."""

    words: dict[tuple[int, int], int] = field(default_factory=dict)
    rest: int = 0

    def bits(self, stream: int, number: int) -> int:
        return self.words.get((stream, number), self.rest)


def turn(number: int, of: int) -> int:
    """Returns a word that takes member `number` of so many."""
    return -(-number * 2**32 // of)


def number(value: int | float) -> ir.Number:
    return ir.Number(type=INT if isinstance(value, int) else REAL, value=value)


def word_type(*words: str, by: tuple[ir.IndexSet, ...] = ()) -> ir.Type:
    return ir.Type(kind="word", words=words, indexed_by=by)


def word(value: str, *others: str) -> ir.Word:
    return ir.Word(type=word_type(value, *others), value=value)


def agent(name: str = "agent") -> ir.Member:
    return ir.Member(name=name, entity_type=ir.EntityType("agent"))


def cell(kind: str, name: str | None = None) -> ir.Member:
    return ir.Member(name=name or kind, entity_type=ir.EntityType("cell", (kind,)))


def of_agent(name: str, type_: ir.Type = INT, who: ir.Expr | None = None) -> ir.FieldRead:
    return ir.FieldRead(type=type_, owner=who or agent(), held_by=ir.EntityType("agent"), name=name)


def of_cell(kind: str, name: str, type_: ir.Type, who: ir.Expr | None = None) -> ir.FieldRead:
    return ir.FieldRead(
        type=type_, owner=who or cell(kind), held_by=ir.EntityType("cell", (kind,)), name=name
    )


def of_world(name: str, type_: ir.Type = INT) -> ir.FieldRead:
    return ir.FieldRead(type=type_, owner=None, held_by=ir.EntityType("world"), name=name)


def plus(*args: ir.Expr, fn: str = "+", type_: ir.Type = INT) -> ir.Arithmetic:
    return ir.Arithmetic(type=type_, fn=fn, args=args)


def compare(left: ir.Expr, fn: str, right: ir.Expr) -> ir.Compare:
    return ir.Compare(fn=fn, left=left, right=right)


def index(who: str = "agent") -> ir.Attribute:
    return ir.Attribute(type=INT, owner=agent(who), name="index")


def is_agent(number_: int, who: str = "agent") -> ir.Compare:
    return compare(index(who), "==", number(number_))


def chose(action: int, who: str = "agent") -> ir.Chose:
    return ir.Chose(agent=agent(who), action=action)


def agents(name: str = "agent", **facts: object) -> ir.Domain:
    return ir.Domain(var=agent(name), **facts)


def cells(kind: str, name: str | None = None, **facts: object) -> ir.Domain:
    return ir.Domain(var=cell(kind, name), **facts)


def near(shape: str, anchor: ir.Member) -> ir.Near:
    return ir.Near(shape=shape, anchor=anchor)


def each(domain: ir.Domain, *body: ir.Statement) -> ir.Each:
    return ir.Each(domain=domain, body=body)


def send(to: ir.Domain, who: ir.Expr | None = None, *, pool: int = 0, **facts: object) -> ir.Send:
    """The streams of pool p are 1000 + p for the order and 2000 + p for the headings."""
    return ir.Send(
        who=who or agent(),
        domain=to,
        pool=pool,
        cell_stream=1000 + pool,
        heading_stream=2000 + pool,
        **facts,
    )


def phase(*body: ir.Statement, name: str = "act") -> ir.Phase:
    marks = tuple(
        dict.fromkeys(
            node.shape for part in body for node in ir.walk(part) if isinstance(node, ir.Mark)
        )
    )
    return ir.Phase(label=name, name=name, body=body, marks=marks)


def line(length: int, name: str = "ray", see_through: bool = False) -> ir.Shape:
    return ir.Shape(
        name=name,
        lanes=(tuple((i, 0) for i in range(1, length + 1)),),
        see_through=see_through,
        directed=True,
    )


def kind(name: str, glyph: str, *fields: ir.VarField, blocks: tuple[ir.Block, ...] = ()) -> ir.Kind:
    own = tuple(
        field.model_copy(update={"held_by": ir.EntityType("cell", (name,))}) for field in fields
    )
    return ir.Kind(name=name, glyph=glyph, fields=own, blocks=blocks)


def var(held_by: str, name: str, type_: ir.Type = INT, **facts: object) -> ir.VarField:
    return ir.VarField(held_by=ir.EntityType(held_by), name=name, type=type_, **facts)


def game(
    *turns: ir.TurnNode,
    rows: tuple[str, ...] = ("...",),
    number_of_agents: int = 1,
    **facts: object,
) -> ir.Game:
    """A game whose map may hold floor `.` and wall `#`, and whose start sends every agent to the floor."""
    floor, wall = (
        kind("floor", "."),
        kind("wall", "#", blocks=(ir.Block(what="agents"), ir.Block(what="ray"))),
    )
    declared: dict[str, object] = {
        "name": "small",
        "title": "Small",
        "episode": number(10),
        "kinds": (floor, wall),
        "rows": rows,
        "agents": ir.Agents(
            number=number_of_agents,
            actions=ACTS,
            relative=True,
            fields=facts.pop("agent_fields", ()),
        ),
        "start": phase(each(agents(), send(cells("floor"), pool=99)), name="start"),
        "schedule": turns,
        "window": ir.Window(ahead=1, behind=1, left=1, right=1),
    } | facts
    declared.setdefault(
        "glyphs", tuple(ir.GlyphMeaning(glyph=k.glyph, kind=k.name) for k in declared["kinds"])
    )
    return ir.Game(**declared)


def world_of(
    game_: ir.Game, *places: tuple[int, int] | None, headings: tuple[int, ...] = ()
) -> World:
    """Returns the game's first state with the agents put where the test wants them."""
    world = copied(reset(game_, default_params(game_), Table()))
    for number_, place in enumerate(places):
        world.position[number_] = None if place is None else Cell(*place)
    for number_, heading in enumerate(headings):
        world.heading[number_] = heading
    return world


def instance(
    game_: ir.Game, world: World | None = None, actions: tuple[int, ...] = (), **names: object
) -> Instance:
    """Returns a place to evaluate expressions in."""
    return Instance(board_of(game_), world or world_of(game_), actions, Table(), names)
