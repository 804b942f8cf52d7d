"""Queries over a typed game: declarations by name, characters of the map, what the rules contain.

They say what a game declares and where, never what its rules mean: the interpreter may ask them and
stays an oracle.
"""

from collections.abc import Callable
from types import UnionType

from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.ir.entity_types import AGENTS, EntityType
from sjdsl.compiler.ir.expressions import (
    Among,
    At,
    Attribute,
    Compare,
    Count,
    Domain,
    Expr,
    FieldRead,
    InAgents,
    InCell,
    Logic,
    Member,
    Near,
    Shape,
    StandsAt,
)
from sjdsl.compiler.ir.game import (
    ActionWithArguments,
    Block,
    Event,
    Game,
    GlyphMeaning,
    Kept,
    Kind,
    Movers,
    Observable,
    Phase,
    Task,
    VarField,
)
from sjdsl.compiler.ir.node import Node
from sjdsl.compiler.ir.statements import Remove, Send, Set
from sjdsl.compiler.ir.task_rows import all_parts, number_of_ways

Start = int | float | str | None
Lanes = tuple[tuple[tuple[int, int], ...], ...]


def contains(node: Node, *classes: type[Node] | UnionType) -> bool:
    """Returns whether a node of one of these classes is in `node`, or is it."""
    return any(isinstance(inner, classes) for inner in walk(node))


def is_any_or_all(e: Node) -> bool:
    """Returns whether an expression is written `any(D)` or `all(D)`.

    Elaboration makes them comparisons of counts, and gives the count the origin of the whole
    expression. A `count(D) > 0` that an author wrote has a shorter one inside.
    """
    return (
        isinstance(e, Compare)
        and isinstance(e.left, Count)
        and e.left.origin is not None
        and e.left.origin == e.origin
    )


def is_number_of_cells(e: Node) -> bool:
    """Returns whether an expression counts all cells of some kinds: the map decides it."""
    if not isinstance(e, Count):
        return False
    domain = e.domain
    return (
        domain.var.entity_type.what == "cell"
        and domain.restriction is None
        and domain.where is None
    )


def title_of(game: Game) -> str:
    """Returns the title of a game, with the variants of it that were chosen."""
    title = game.title or game.name
    return f"{title} ({'+'.join(game.chosen)})" if game.chosen else title


def all_fields(game: Game) -> tuple[VarField, ...]:
    """Returns every declared variable.

    Those of cells, kind by kind, then those of agents, of movers, sort by sort, and of the world.
    """
    of_cells = (field for kind in game.kinds for field in kind.fields)
    return (
        *of_cells,
        *game.agents.fields,
        *(field for movers in game.movers for field in movers.fields),
        *game.fields,
    )


def declared_field(game: Game, read: FieldRead, kind: str | None = None) -> VarField:
    """Returns the declaration of the variable that is read or written.

    `kind`: which of the kinds it may be of, instead of the first.
    """
    names = read.held_by.names[:1] if kind is None else (kind,)
    owner = EntityType(read.held_by.what, names)
    return next(f for f in all_fields(game) if (f.held_by, f.name) == (owner, read.name))


def are_one_field(first: FieldRead | VarField | Kept, second: FieldRead | VarField) -> bool:
    """Returns whether a field that is declared, kept, read or written may be the same as another.

    It may not if their holders differ, such as cells of two kinds.
    """
    return first.name == second.name and first.held_by.overlaps(second.held_by)


def sets(node: Node, declared: VarField) -> bool:
    """Returns whether a node sets one of the variables declared, or an entry of it."""
    if not isinstance(node, Set) or not isinstance(node.target, FieldRead | At):
        return False
    return are_one_field(written_field(node.target), declared)


def written_field(target: Expr) -> FieldRead:
    """Returns the variable that a `set` or `add` writes.

    Of an entry, the variable it is an entry of.
    """
    while isinstance(target, At):
        target = target.row
    assert isinstance(target, FieldRead), target
    return target


def written_keys(target: Expr) -> tuple[Expr, ...]:
    """Returns the keys of the entry that a `set` or `add` writes, outermost index set first."""
    return (*written_keys(target.row), target.key) if isinstance(target, At) else ()


# What every agent has of itself: no field has such a name.
ATTRIBUTES = ("index", "heading", "moved", "away", "row", "col")


def seen_heading(game: Game) -> Observable | None:
    """Returns the heading of other agents as it is seen; None if it never is."""
    return next((s for s in game.observables if s.what == "heading"), None)


def shows_attribute(observable: Observable) -> bool:
    """Returns whether an observation shows what every agent has of itself, and not a field."""
    is_of_agents = observable.what in ("own", "other", "everyone")
    return is_of_agents and observable.field in ATTRIBUTES and observable.value is None


def shown_field(game: Game, observable: Observable) -> VarField:
    """Returns the declaration of the variable that an observation shows."""
    return next(
        f
        for f in all_fields(game)
        if (f.held_by, f.name) == (observable.entity_type, observable.field)
    )


def kind_named(game: Game, name: str) -> Kind:
    """Returns the declaration of a kind of cell."""
    return next(kind for kind in game.kinds if kind.name == name)


def shape_named(game: Game, name: str) -> Shape:
    """Returns the declaration of a shape."""
    return next(shape for shape in game.shapes if shape.name == name)


def event_named(game: Game, name: str) -> Event:
    """Returns the declaration of an event."""
    return next(event for event in game.events if event.name == name)


def action_named(game: Game, name: str) -> ActionWithArguments:
    """Returns the declaration of an action with arguments."""
    return next(action for action in game.agents.with_arguments if action.name == name)


def counts_of(event: Event) -> tuple[tuple[str | None, str], ...]:
    """Returns what is counted of an event, each with the name it is reported by.

    `("red", "eaten[red]")`, or `(None, "eaten")`.
    """
    if event.by is None:
        return ((None, event.name),)
    return tuple((key, f"{event.name}[{key}]") for key in event.by.keys)


def phases_of(game: Game) -> tuple[Phase, ...]:
    """Returns the draw of the task if there is one, those that begin, and those of the schedule."""
    drawn = () if game.task is None else (game.task.draw,)
    scheduled = (turn for turn in game.schedule if isinstance(turn, Phase))
    return (*drawn, *beginning_phases(game), *scheduled)


def beginning_phases(game: Game) -> tuple[Phase, ...]:
    """Returns `start` and the phases at the start, in the order in which a trial begins."""
    return (game.start, *game.starting)


def task_space(task: Task) -> int:
    """Returns how many tasks there are, all equally likely."""
    return number_of_ways(task, all_parts(task))


def marking_phases(game: Game) -> tuple[Phase, ...]:
    """Returns the phases that mark cells."""
    return tuple(phase for phase in phases_of(game) if phase.marks)


def kinds_by_glyph(game: Game) -> dict[str, str]:
    """Returns the kind that each character of a map stands for."""
    return {meaning.glyph: meaning.kind for meaning in game.glyphs}


def glyphs_of(game: Game, kinds: tuple[str, ...]) -> str:
    """Returns the characters that stand for cells of these kinds."""
    return "".join(meaning.glyph for meaning in game.glyphs if meaning.kind in kinds)


def starts_of(game: Game, meaning: GlyphMeaning) -> dict[str, Start]:
    """Returns the value at the start of each variable of the cells that a character stands for."""
    starts: dict[str, Start] = {
        field.name: field.start for field in kind_named(game, meaning.kind).fields
    }
    return starts | dict(meaning.starts)


def blocks_always(kind: Kind, what: str = "agents") -> bool:
    """Returns whether cells of a kind always stop agents, or the lanes of the shape `what`."""
    return any(block.what == what and block.condition is None for block in kind.blocks)


def closes_paths(block: Block) -> bool:
    """Returns whether a block closes cells to the paths of policies where its condition holds.

    Of the agent, the condition reads fields and its number only, which don't change on the way.
    """
    if block.what != "agents" or block.condition is None:
        return False
    nodes = list(walk(block.condition))
    named = [node for node in nodes if isinstance(node, Member) and node.name == "agent"]
    owners = [
        node.owner
        for node in nodes
        if isinstance(node, FieldRead) or (isinstance(node, Attribute) and node.name == "index")
    ]
    read = [owner for owner in owners if isinstance(owner, Member) and owner.name == "agent"]
    return 0 < len(named) == len(read)


def movers_named(game: Game, name: str) -> Movers:
    """Returns the declaration of a sort of movers."""
    return next(movers for movers in game.movers if movers.name == name)


def body_type(who: Expr) -> EntityType:
    """Returns the entity type of a variable; what another expression gives is an agent."""
    return who.entity_type if isinstance(who, Member) else AGENTS


def can_be_away(game: Game, entity_type: EntityType = AGENTS) -> bool:
    """Returns whether an agent, or a mover of a sort, can be off the map.

    Sent away for some ticks, or removed.
    """
    for node in walk(game):
        if isinstance(node, Remove) or (isinstance(node, Send) and node.after is not None):
            if body_type(node.who) == entity_type:
                return True
    return False


def body_types(game: Game) -> tuple[EntityType, ...]:
    """Returns the types of all who stand on cells: the agents, then those of movers."""
    return (AGENTS, *(movers.entity_type for movers in game.movers))


def view_size(game: Game) -> tuple[int, int]:
    """Returns the rows and columns of a window."""
    window = game.window
    return window.ahead + 1 + window.behind, window.left + 1 + window.right


def most_members(domain: Domain, game: Game) -> int:
    """Returns the most members that a domain can have, its condition aside."""
    match domain.var.entity_type.what:
        case "agent":
            population = game.agents.number
        case "mover":
            population = movers_named(game, domain.var.entity_type.name).number
        case "cell":
            population = num_cells(game, domain.var.kinds)
        case "world":
            raise AssertionError(domain)
    if domain.on is not None:
        population = min(population, num_cells(game, domain.on.kinds))
    return most_restricted(domain, population, lambda near: lanes_of(near, game))


def most_restricted(domain: Domain, population: int, lanes: Callable[[Near], Lanes]) -> int:
    """Returns the most members that a domain can have by its restriction.

    Args:
      population: how many there are without it.
      lanes: returns the lanes (paths of cells) of a shape.
    """
    if cell_under_all(domain) is not None:
        return min(population, 1)
    match domain.restriction:
        case Near():
            return min(population, sum(map(len, lanes(domain.restriction))))
        case Among():
            return min(population, len(domain.restriction.members))
        case InAgents() if domain.restriction.value.type.kind != "agents":
            return min(population, 1)
        case InCell():
            return min(population, 1)
        case _:
            return population


def cell_under_all(domain: Domain) -> Member | None:
    """Returns the cell, bound around a domain, on which each of its members stands.

    None if none is known. As in `agent on gate` inside `each gate`. So there is one member at most.
    """
    condition = domain.where
    parts: tuple[Expr | None, ...] = (condition,)
    if isinstance(condition, Logic) and condition.fn == "and":
        parts = condition.args
    for part in parts:
        if isinstance(part, StandsAt) and part.agent.name == domain.var.name:
            if domain.on is None or part.cell.name != domain.on.name:
                return part.cell
    return None


def num_cells(game: Game, kinds: tuple[str, ...]) -> int:
    """Returns how many cells of these kinds the map has."""
    glyphs = glyphs_of(game, kinds)
    return sum(row.count(glyph) for row in game.rows for glyph in glyphs)


def lanes_of(near: Near, game: Game) -> Lanes:
    """Returns the lanes of the shape in which members are looked for.

    Policies have shapes of their own.
    """
    return next(
        shape.lanes for shape in (*game.shapes, *game.policy_shapes) if shape.name == near.shape
    )
