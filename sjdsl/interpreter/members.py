"""Enumerates the members of a domain, with the number of each among all possible members."""

from __future__ import annotations

from dataclasses import dataclass
from typing import assert_never

from sjdsl.compiler import ir
from sjdsl.interpreter import evaluate, shapes
from sjdsl.interpreter.board import Board, cells_of
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import Cell, Value


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
    match domain.place:
        case ir.Near():
            return shapes.size(board.shapes[domain.place.shape])
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


def found(domain: ir.Domain, here: Instance) -> list[Found]:
    """Returns the members in the order of their numbers."""
    members = (_restricted(domain, member, number, here) for member, number in _candidates(domain, here))
    return [m for m in members if m is not None]


def nearest(domain: ir.Domain, here: Instance) -> list[Found | None]:
    """Returns for each lane of the domain's shape its nearest member, None where there is none."""
    assert isinstance(domain.place, ir.Near), "only a shape has lanes"
    return [_first(domain, lane, here) for lane in shapes.lanes(domain.place, here)]


def is_here(agent: int, here: Instance) -> bool:
    """Returns whether an agent is not away."""
    return here.world.away[agent] is None


def agent_on(cell: Cell, here: Instance) -> int | None:
    """Returns the agent that stands on a cell."""
    return here.world.position.index(cell) if cell in here.world.position else None


def _first(domain: ir.Domain, lane: list[shapes.Seen], here: Instance) -> Found | None:
    for cell, number in lane:
        if domain.var.who == "agent":
            agent = agent_on(cell, here)
            member = None if agent is None else _restricted(domain, agent, agent, here)
        else:
            is_kind = here.board.kind_of[cell] in domain.var.kinds
            member = _restricted(domain, cell, number, here) if is_kind else None
        if member is not None:
            return member
    return None


def _candidates(domain: ir.Domain, here: Instance) -> list[tuple[int | Cell, int]]:
    if domain.var.who == "agent":
        return [(agent, agent) for agent in sorted(_agents(domain.place, here)) if is_here(agent, here)]
    return _cells(domain, here)


def _agents(place: ir.Place | None, here: Instance) -> set[int]:
    match place:
        case None:
            return set(range(here.board.agents))
        case ir.Near():
            cells = shapes.cells_in(place, here)
            return {agent for agent, cell in enumerate(here.world.position) if cell in cells}
        case ir.InAgents():
            return set(evaluate.agents_in(evaluate.evaluate(place.value, here)))
        case ir.Among():
            return {here.names[m.name] for m in place.members}
        case _:
            assert_never(place)


def _cells(domain: ir.Domain, here: Instance) -> list[tuple[int | Cell, int]]:
    all_cells = cells_of(here.board, domain.var.kinds)
    match domain.place:
        case None:
            return [(cell, number) for number, cell in enumerate(all_cells)]
        case ir.Near():
            near = shapes.cells_in(domain.place, here)
            inside = [(cell, number) for cell, number in near.items() if here.board.kind_of[cell] in domain.var.kinds]
            return sorted(inside, key=lambda pair: pair[1])
        case ir.Among():
            chosen = {here.names[m.name] for m in domain.place.members}
            return [(cell, number) for number, cell in enumerate(all_cells) if cell in chosen]
        case ir.InAgents():
            raise AssertionError("cells are not members of a set of agents")
        case _:
            assert_never(domain.place)


def _restricted(domain: ir.Domain, member: int | Cell, number: int, here: Instance) -> Found | None:
    """Returns the member with what it binds if it passes `on` and `where`."""
    names: dict[str, Value] = {domain.var.name: member}
    if domain.on is not None:
        assert isinstance(member, int), "only agents stand on something"
        cell = here.world.position[member]
        if cell is None or here.board.kind_of[cell] not in domain.on.kinds:
            return None
        names[domain.on.name] = cell
    if domain.where is not None and not evaluate.evaluate(domain.where, here.binding(names)):
        return None
    return Found(member, number, names)
