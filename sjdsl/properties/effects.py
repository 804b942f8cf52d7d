"""What an expression reads of the state and what a statement writes: decides `conserved`."""

from collections.abc import Iterator

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import all_fields, beginning_phases, body_type, written_field

# Part of the state: ("agent", field), ("cell", kind, field), ("mover", type, field), ("world",
# field), ("event", name), or one of those below.
Part = tuple[str, ...]
PLACE: Part = ("place",)  # of agents and movers alike
HEADING: Part = ("heading",)  # of agents
STEP: Part = ("step",)


def is_untouched(e: ir.Expr, game: ir.Game, sends_later: bool = False) -> bool:
    """Returns whether no rule writes anything that the expression reads.

    Args:
      sends_later: whether a `send` takes time in other sizes of the game, if not in this one.
    """
    written = set(writes(game))
    if sends_later:
        sends = (node for node in ir.walk(game) if isinstance(node, ir.Send))
        written |= {part_of("away", body_type(send.who)) for send in sends}
    return not reads_and_blocks(e, game) & written


def reads_and_blocks(node: ir.Node, game: ir.Game) -> set[Part]:
    """Returns what an expression reads, and what decides where the lanes of its shapes end."""
    blocks = [block for kind in game.kinds for block in kind.blocks]
    blocks += game.agents.blocks
    parts: set[Part] = set()
    shapes: set[str] = set()
    waiting = [node]
    while waiting:
        following = waiting.pop()
        parts |= set(reads(following))
        new_shapes = {n.shape for n in ir.walk(following) if isinstance(n, ir.Near)} - shapes
        shapes |= new_shapes
        waiting += [block for block in blocks if block.what in new_shapes]
    return parts


def reads(node: ir.Node) -> Iterator[Part]:
    """Yields what an expression reads itself.

    Wherever agents are counted, whether they are away is read.
    """
    for n in ir.walk(node):
        match n:
            case ir.FieldRead():
                yield from _parts_of_field(n)
            case ir.Attribute(name="heading" | "moved" | "away"):
                yield part_of(n.name, body_type(n.owner))
            case ir.Attribute(
                name="row" | "col", owner=ir.Member(entity_type=ir.EntityType(what="cell"))
            ):
                pass
            case ir.Attribute(name="row" | "col"):
                yield PLACE
            case ir.Distance():
                members = [end for end in (n.left, n.right) if isinstance(end, ir.Member)]
                if any(member.entity_type.what != "cell" for member in members):
                    yield PLACE
            case ir.Bearing():
                yield from (PLACE, part_of("heading", body_type(n.left)))
            case ir.Step():
                yield STEP
            case ir.EventTotal():
                yield ("event", n.name)
            case ir.Near():
                yield from (PLACE, part_of("heading", body_type(n.anchor)))
            case ir.Unoccupied() | ir.StandsOn() | ir.StandsAt():
                yield from (PLACE, HEADING)
            case ir.Domain(var=ir.Member(entity_type=ir.EntityType(what="agent" | "mover"))):
                yield part_of("away", body_type(n.var))
                if n.on is not None:
                    yield PLACE
            case ir.Wander():
                yield PLACE
            case _:
                pass


def writes(game: ir.Game) -> Iterator[Part]:
    """Yields what the schedule can write.

    Agents can be away only if a `send` takes time or an agent is removed.
    """
    yield STEP
    if any(isinstance(turn, ir.Tick) for turn in game.schedule):
        for field in all_fields(game):
            if field.timer:
                yield field_part(field.held_by, field.name)
    for turn in game.schedule:
        for node in ir.walk(turn):
            yield from written_by(node)
    if game.trials is not None:
        yield from _changed_between(game, game.trials)


def _changed_between(game: ir.Game, trials: ir.Trials) -> Iterator[Part]:
    """Yields what can differ from trial to trial though no phase of the schedule writes it."""
    yield field_part(ir.EntityType("world"), "trial")
    kept = {field_part(field.held_by, field.name) for field in trials.kept}
    for phase in beginning_phases(game):
        for node in ir.walk(phase):
            yield from (part for part in written_by(node) if part not in kept)


def written_by(n: ir.Node) -> Iterator[Part]:
    """Yields what one statement can write; nothing for a compound statement."""
    match n:
        case ir.Set() | ir.Add():
            yield from _parts_of_field(written_field(n.target))
        case ir.Tally():
            yield ("event", n.event)
        case ir.Move():
            entity_type = body_type(n.domain.var)
            yield from (PLACE, part_of("heading", entity_type), part_of("moved", entity_type))
        case ir.Send():
            yield from (PLACE, part_of("heading", body_type(n.who)))
            if n.after is not None and n.after.type.high > 0:
                yield part_of("away", body_type(n.who))
        case ir.Shift():
            yield from (PLACE, part_of("heading", body_type(n.who)))
        case ir.Face():
            yield HEADING
        case ir.Remove():
            yield from (PLACE, part_of("away", body_type(n.who)))
        case _:
            pass


def _parts_of_field(read: ir.FieldRead) -> Iterator[Part]:
    """Yields the fields that may be read: one for each kind, or type of mover, of the owner."""
    held_by = read.held_by
    for name in held_by.names:
        yield field_part(ir.EntityType(held_by.what, (name,)), read.name)
    if not held_by.names:
        yield field_part(held_by, read.name)


def field_part(held_by: ir.EntityType, name: str) -> Part:
    """Returns the part that a field is."""
    if held_by.names:
        return (held_by.what, held_by.name, name)
    return (held_by.what, name)


def part_of(attribute: str, entity_type: ir.EntityType) -> Part:
    """Returns `heading`, `moved` or `away` of all agents, or of all movers of a type.

    The heading of a mover is one of its fields.
    """
    return ("mover", entity_type.name, attribute) if entity_type.what == "mover" else (attribute,)
