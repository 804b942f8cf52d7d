"""Interprets `send` and `remove`: a random free cell, a delay away from the map, and the respawn of agents at a `tick`."""

from functools import lru_cache

from sjdsl.compiler import ir
from sjdsl.interpreter.board import Board, cells_of
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import HEADINGS, Away, Cell, Facing, Pool, World
from sjdsl.interpreter.threefry import return_stream
from sjdsl.interpreter.writes import Sending


def send(phase: str, sends: list[Sending], here: Instance, world: World) -> None:
    """Changes the places of `world`, which holds the snapshot's: pool by pool, in each pool in id order. `phase`: its name."""
    for pool in sorted({s.send.pool for s in sends}):
        together = sorted((s for s in sends if s.send.pool == pool), key=lambda s: s.agent)
        order = together[0].send.order_stream
        # who may have to stay does not make room for others
        leaving = set() if _may_stay(order, here.board) else {s.agent for s in together}
        free = free_cells(together[0].send.domain, leaving, here)
        for agent, statement, ticks in together:
            if ticks > 0:
                _leave(agent, Away(ticks, Pool(phase, pool), statement.facing), world)
            elif free:
                _enter(agent, here.take(order, agent, free)[0], statement.facing, statement.heading_stream, here, world)
            else:
                assert statement.stay, f"no free cell for agent {agent}"


@lru_cache(maxsize=256)
def _may_stay(order_stream: int, board: Board) -> bool:
    """Returns whether any statement that sends to this pool says `otherwise stay`."""
    sends = (n for n in ir.walk(board.game) if isinstance(n, ir.Send))
    return any(s.stay for s in sends if s.order_stream == order_stream)


def remove(agent: int, world: World) -> None:
    """Takes an agent away for ever."""
    _leave(agent, Away(0, None, None), world)


def bring_back(here: Instance, world: World) -> None:
    """Lets one tick pass for the agents that are away; who has none left comes back, or waits for a free cell."""
    due: dict[Pool, list[int]] = {}
    for agent, away in enumerate(here.world.away):
        if away is not None and away.ticks == 1 and away.pool is not None:
            due.setdefault(away.pool, []).append(agent)
        elif away is not None and away.ticks > 1:
            world.away[agent] = away._replace(ticks=away.ticks - 1)
    for pool in (p for p in here.board.pools if p in due):
        statement = here.board.pools[pool]
        # Two pools may share cells: what an earlier one filled is not free any more.
        filled = {cell for cell in world.position if cell is not None}
        free = [c for c in free_cells(statement.domain, set(), here) if c not in filled]
        order = return_stream(statement.order_stream)
        for agent in due[pool]:
            away = here.world.away[agent]
            if free and away is not None:
                _enter(agent, here.take(order, agent, free)[0], away.facing, return_stream(statement.heading_stream), here, world)


def free_cells(domain: ir.Domain, leaving: set[int], here: Instance) -> list[Cell]:
    """Returns the destination's free cells in reading order. The cells of `leaving` agents are free."""
    assert domain.restriction is None, "a destination is not around anything"
    covered = {cell for agent, cell in enumerate(here.world.position) if agent not in leaving}
    cells = cells_of(here.board, domain.var.kinds)
    wanted = [c for c in cells if domain.where is None or evaluate(domain.where, here.only({domain.var.name: c}))]
    return [c for c in wanted if c not in covered]


def _enter(agent: int, cell: Cell, facing: Facing | None, stream: int, here: Instance, world: World) -> None:
    world.position[agent] = cell
    world.away[agent] = None
    match facing:
        case None:
            world.heading[agent] = here.word(stream, agent) >> 30
        case "same":
            pass
        case _:
            world.heading[agent] = HEADINGS.index(facing)


def _leave(agent: int, away: Away, world: World) -> None:
    world.position[agent] = None
    world.away[agent] = away
