"""Read and write sets: which parts of the state an expression reads and a statement writes. This decides `conserved` statically."""

from collections.abc import Iterator

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import all_fields, body_sort, written_field

Part = tuple[
    str, ...
]  # ("agent", field), ("cell", kind, field), ("mover", sort, field), ("world", field), or one of those below
PLACE, HEADING, MOVED, AWAY, STEP = (
    ("place",),
    ("heading",),
    ("moved",),
    ("away",),
    ("step",),
)  # places of agents and movers alike


def is_untouched(e: ir.Expr, game: ir.Game, sent_away: bool = False) -> bool:
    """Returns whether no rule writes anything that the expression reads. `sent_away`: a `send` that takes no time here takes some elsewhere."""
    away = (
        {part_of("away", body_sort(n.who)) for n in ir.walk(game) if isinstance(n, ir.Send)}
        if sent_away
        else set()
    )
    return not reads_and_blocks(e, game) & {*writes(game), *away}


def reads_and_blocks(node: ir.Node, game: ir.Game) -> set[Part]:
    """Returns what an expression reads, and what the conditions read under which something ends the lanes of its shapes."""
    blocks = [block for kind in game.kinds for block in kind.blocks] + list(game.agents.blocks)
    found, shapes, waiting = set[Part](), set[str](), [node]
    while waiting:
        following = waiting.pop()
        found |= set(reads(following))
        more = {n.shape for n in ir.walk(following) if isinstance(n, ir.Near)} - shapes
        shapes |= more
        waiting += [block for block in blocks if block.what in more]
    return found


def reads(node: ir.Node) -> Iterator[Part]:
    """Yields what an expression reads itself; whether agents are away is read wherever agents are counted."""
    for n in ir.walk(node):
        match n:
            case ir.FieldRead():
                yield from _field(n)
            case ir.Attribute(name="heading" | "moved" | "away"):
                yield part_of(n.name, body_sort(n.owner))
            case ir.Attribute(name="row" | "col", owner=owner) if not (
                isinstance(owner, ir.Member) and owner.sort.what == "cell"
            ):
                yield PLACE
            case ir.Distance() if any(
                isinstance(place, ir.Member) and place.sort.what != "cell"
                for place in (n.left, n.right)
            ):
                yield PLACE
            case ir.Step():
                yield STEP
            case ir.EventTotal():
                yield ("event", n.name)
            case ir.Near():
                yield from (PLACE, part_of("heading", body_sort(n.anchor)))
            case ir.Unoccupied() | ir.StandsOn() | ir.StandsAt():
                yield from (PLACE, HEADING)
            case ir.Domain(var=ir.Member(sort=ir.Sort(what="agent" | "mover"))):
                yield part_of("away", body_sort(n.var))
                if n.on is not None:
                    yield PLACE
            case ir.Wander():
                yield PLACE
            case _:
                pass


def writes(game: ir.Game) -> Iterator[Part]:
    """Yields what the schedule can write. Agents can be away only if a `send` takes time or an agent is removed."""
    yield STEP
    if any(isinstance(turn, ir.Tick) for turn in game.schedule):
        yield from (
            field_part(f.held_by.what, f.held_by.name, f.name) for f in all_fields(game) if f.timer
        )
    for n in (node for turn in game.schedule for node in ir.walk(turn)):
        yield from written_by(n)
    if game.trials is not None:
        yield from _laid_anew(game, game.trials)


def _laid_anew(game: ir.Game, trials: ir.Trials) -> Iterator[Part]:
    """Yields what can differ from trial to trial though no phase of the schedule writes it."""
    yield field_part("world", "", "trial")
    kept = {field_part(field.held_by.what, field.held_by.name, field.name) for field in trials.kept}
    for n in ir.walk(game.start):
        yield from (part for part in written_by(n) if part not in kept)


def written_by(n: ir.Node) -> Iterator[Part]:
    """Yields what one statement can write; nothing for a compound statement."""
    match n:
        case ir.Set() | ir.Add():
            yield from _field(written_field(n.target))
        case ir.Tally():
            yield ("event", n.event)
        case ir.Move():
            sort = body_sort(n.domain.var)
            yield from (PLACE, part_of("heading", sort), part_of("moved", sort))
        case ir.Send():
            yield from (PLACE, part_of("heading", body_sort(n.who)))
            if n.after is not None and n.after.type.high > 0:
                yield part_of("away", body_sort(n.who))
        case ir.Shift():
            yield from (PLACE, part_of("heading", body_sort(n.who)))
        case ir.Remove():
            yield from (PLACE, part_of("away", body_sort(n.who)))
        case _:
            pass


def _field(read: ir.FieldRead) -> Iterator[Part]:
    yield from (
        field_part(read.held_by.what, name, read.name)
        for name in read.held_by.names or (read.held_by.name,)
    )


def field_part(place: str, kind: str, name: str) -> Part:
    """Returns the part that a variable is. `kind`: the kind of cell, or sort of movers, that has it."""
    return (place, kind, name) if place in ("cell", "mover") else (place, name)


def part_of(attribute: str, sort: ir.Sort) -> Part:
    """Returns the heading of agents, whether they moved or are away, or the same of movers of a sort; a mover's heading is its field."""
    return ("mover", sort.name, attribute) if sort.what == "mover" else (attribute,)
