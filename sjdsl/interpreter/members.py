"""Members of domains, and the number of each among all possible members.

Members are agents, movers and cells.
"""

from dataclasses import dataclass

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import movers_named
from sjdsl.interpreter import shapes
from sjdsl.interpreter.board import Board, cells_of
from sjdsl.interpreter.bodies import Body, away_of, number_of
from sjdsl.interpreter.state import Cell, Mover, Value, World


@dataclass(frozen=True)
class Bound:
    """A member of a domain: an agent, a mover or a cell, its number, and the variables it binds."""

    member: Body | Cell
    number: int
    names: dict[str, Value]


def radix(domain: ir.Domain, board: Board) -> int:
    """Returns how many members the domain could have."""
    if isinstance(domain.restriction, ir.Near) and domain.var.entity_type.what == "cell":
        return shapes.num_places(board.shapes[domain.restriction.shape])
    return population(domain, board)


def population(domain: ir.Domain, board: Board) -> int:
    """Returns how many agents, movers of the domain's entity type, or cells of its kinds exist."""
    match domain.var.entity_type.what:
        case "agent":
            return board.agents
        case "mover":
            return movers_named(board.game, domain.var.entity_type.name).number
        case "cell":
            return len(cells_of(board, domain.var.kinds))
        case "world":
            raise AssertionError(domain)


def number_in_population(domain: ir.Domain, member: Bound, board: Board) -> int:
    """Returns the number of an agent or a mover, or of a cell among all of the domain's kinds."""
    if isinstance(member.member, Cell):
        return cells_of(board, domain.var.kinds).index(member.member)
    return number_of(member.member)


def is_on_map(body: Body, world: World) -> bool:
    """Returns whether an agent or a mover is on the map."""
    return away_of(body, world) is None


def body_on(cell: Cell, domain: ir.Domain, world: World) -> Body | None:
    """Returns the agent, or the mover of the domain's entity type, that stands on a cell."""
    if domain.var.entity_type.what == "agent":
        return agent_on(cell, world)
    entity_type = domain.var.entity_type.name
    places = world.movers[entity_type].position
    return Mover(entity_type, places.index(cell)) if cell in places else None


def agent_on(cell: Cell, world: World) -> int | None:
    """Returns the agent that stands on a cell."""
    return world.position.index(cell) if cell in world.position else None
