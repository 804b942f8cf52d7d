"""Bodies: agents and movers alike have a place and a heading, occupy a cell, and may be away."""

from collections.abc import Collection, Iterator
from typing import TypeAlias

from sjdsl.compiler.ir.entity_types import AGENTS, EntityType
from sjdsl.interpreter.state import HEADINGS, Away, Cell, Herd, Mover, World

Body: TypeAlias = int | Mover  # an agent's number, or a mover


def herd_of(body: Body, world: World) -> World | Herd:
    """Returns the object with the places of all bodies of the same entity type."""
    return world.movers[body.entity_type] if isinstance(body, Mover) else world


def herds(world: World) -> dict[EntityType, World | Herd]:
    """Returns the objects with the places of the agents, and of each entity type of movers."""
    return {
        AGENTS: world,
        **{EntityType("mover", (name,)): herd for name, herd in world.movers.items()},
    }


def type_of_body(body: Body) -> EntityType:
    """Returns the entity type of a body."""
    return EntityType("mover", (body.entity_type,)) if isinstance(body, Mover) else AGENTS


def number_of(body: Body) -> int:
    """Returns the number of a body among those of its entity type."""
    return body.number if isinstance(body, Mover) else body


def where_is(body: Body, world: World) -> Cell | None:
    """Returns the cell on which a body stands; None while it is away."""
    return herd_of(body, world).position[number_of(body)]


def away_of(body: Body, world: World) -> Away | None:
    """Returns how a body is away; None while it is on the map."""
    return herd_of(body, world).away[number_of(body)]


def heading_of(body: Body, world: World) -> int:
    """Returns the heading of a body: 0 north, 1 east, 2 south, 3 west."""
    if isinstance(body, Mover):
        return HEADINGS.index(world.movers[body.entity_type].fields["heading"][body.number])
    return world.heading[body]


def turn(body: Body, heading: int, world: World) -> None:
    """Turns a body to a heading, numbered as by `heading_of`."""
    if isinstance(body, Mover):
        world.movers[body.entity_type].fields["heading"][body.number] = HEADINGS[heading]
    else:
        world.heading[body] = heading


def bodies(world: World) -> Iterator[Body]:
    """Yields all agents, then all movers of each entity type."""
    yield from range(len(world.position))
    for entity_type, herd in world.movers.items():
        yield from (Mover(entity_type, number) for number in range(len(herd.position)))


def occupied(world: World, without: Collection[Body] = ()) -> set[Cell]:
    """Returns the cells on which a body stands, not counting those in `without`."""
    return {
        cell
        for body in bodies(world)
        if body not in without and (cell := where_is(body, world)) is not None
    }


def is_free(cell: Cell, world: World) -> bool:
    """Returns whether no body stands on a cell."""
    return cell not in world.position and all(
        cell not in herd.position for herd in world.movers.values()
    )
