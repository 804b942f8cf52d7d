"""Members of domains, agents and cells, and the number of each among all possible members."""

from dataclasses import dataclass

from sjdsl.compiler import ir
from sjdsl.interpreter import shapes
from sjdsl.interpreter.board import Board, cells_of
from sjdsl.interpreter.state import Cell, Value, World


@dataclass(frozen=True)
class Found:
    """One member: an agent or a cell, its number, and the variables it binds."""

    member: int | Cell
    number: int
    names: dict[str, Value]


def radix(domain: ir.Domain, board: Board) -> int:
    """Returns how many members the domain could have."""
    if domain.var.who == "agent":
        return board.agents
    match domain.restriction:
        case ir.Near():
            return shapes.size(board.shapes[domain.restriction.shape])
        case _:
            return len(cells_of(board, domain.var.kinds))


def everybody(domain: ir.Domain, board: Board) -> int:
    """Returns how many agents, or cells of the domain's kinds, there are."""
    return board.agents if domain.var.who == "agent" else len(cells_of(board, domain.var.kinds))


def own_number(domain: ir.Domain, member: Found, board: Board) -> int:
    """Returns an agent's id, or a cell's number among the cells of the domain's kinds, wherever it was looked for."""
    if domain.var.who == "agent":
        assert isinstance(member.member, int)
        return member.member
    return cells_of(board, domain.var.kinds).index(member.member)


def is_here(agent: int, world: World) -> bool:
    """Returns whether an agent is not away."""
    return world.away[agent] is None


def agent_on(cell: Cell, world: World) -> int | None:
    """Returns the agent that stands on a cell."""
    return world.position.index(cell) if cell in world.position else None
