"""Interprets `send` and `remove`: a random free cell, a delay away from the map, and the respawn of agents at a `tick`."""

from collections.abc import Mapping
from functools import lru_cache

from sjdsl.compiler import ir
from sjdsl.compiler.ir.free_variables import variables_around
from sjdsl.interpreter.board import Board, cells_of
from sjdsl.interpreter.bodies import (
    Body,
    away_of,
    bodies,
    herd_of,
    number_of,
    occupied,
    sort_of_body,
    turn,
)
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import HEADINGS, Away, Cell, Facing, Pool, Value, World
from sjdsl.interpreter.threefry import return_stream
from sjdsl.interpreter.writes import Sending


def send(phase: str, sends: list[Sending], here: Instance, world: World) -> None:
    """Changes the places of `world`, which holds the snapshot's: pool by pool, in each pool in id order. `phase`: its name."""
    entered: set[Cell] = (
        set()
    )  # pools may share cells: what an earlier one filled is not free any more
    for pool in sorted({s.send.pool for s in sends}):
        together = sorted(
            (s for s in sends if s.send.pool == pool), key=lambda s: number_of(s.agent)
        )
        order = together[0].send.cell_stream
        # who may have to stay does not make room for others
        leaving = set() if _may_stay(order, here.board) else {s.agent for s in together}
        free = [c for c in free_cells(together[0].send.domain, leaving, here) if c not in entered]
        own = any(
            variables_around(s.domain) for s in _sends_to(order, here.board)
        )  # the cells that fit differ from agent to agent
        free = free if own else _fitting(together[0].send.domain, free, {}, here)
        for agent, statement, ticks, names in together:
            fitting = _fitting(statement.domain, free, names, here) if own else free
            if ticks > 0:
                _leave(agent, Away(ticks, Pool(phase, pool), statement.facing), world)
            elif fitting:
                cell = here.take(order, number_of(agent), fitting)[0]
                if own:
                    free.remove(cell)
                entered.add(cell)
                _enter(agent, cell, statement.facing, statement.heading_stream, here, world)
            else:
                assert statement.stay, _no_room(agent, statement)


@lru_cache(maxsize=256)
def _sends_to(cell_stream: int, board: Board) -> tuple[ir.Send, ...]:
    """Returns the statements that send to one pool."""
    return tuple(
        n for n in ir.walk(board.game) if isinstance(n, ir.Send) and n.cell_stream == cell_stream
    )


def _may_stay(cell_stream: int, board: Board) -> bool:
    """Returns whether any statement that sends to this pool says `otherwise stay`."""
    return any(s.stay for s in _sends_to(cell_stream, board))


def _no_room(agent: Body, statement: ir.Send) -> str:
    """Returns what happens on no map that is checked; a scene may have put agents on one that lacks cells."""
    return f"{sort_of_body(agent).name} {number_of(agent)} is sent to {' or '.join(statement.domain.var.kinds)}, where no cell is free"


def remove(agent: Body, world: World) -> None:
    """Takes an agent or a mover away for ever."""
    _leave(agent, Away(0, None, None), world)


def bring_back(here: Instance, world: World) -> None:
    """Lets one tick pass for those who are away; who has none left comes back, or waits for a free cell."""
    due: dict[Pool, list[Body]] = {}
    for agent in bodies(here.world):
        away = away_of(agent, here.world)
        if away is not None and away.ticks == 1 and away.pool is not None:
            due.setdefault(away.pool, []).append(agent)
        elif away is not None and away.ticks > 1:
            herd_of(agent, world).away[number_of(agent)] = away._replace(ticks=away.ticks - 1)
    for pool in (p for p in here.board.pools if p in due):
        statement = here.board.pools[pool]
        filled = occupied(world)
        free = [c for c in free_cells(statement.domain, set(), here) if c not in filled]
        order = return_stream(statement.cell_stream)
        for agent in due[pool]:
            away = away_of(agent, here.world)
            names = {
                variable.name: agent for variable in variables_around(statement.domain)
            }  # the one agent it may name
            fitting = _fitting(statement.domain, free, names, here)
            assert fitting or _may_stay(statement.cell_stream, here.board), _no_room(
                agent, statement
            )
            if fitting and away is not None:
                cell = here.take(order, number_of(agent), fitting)[0]
                free.remove(cell)
                _enter(
                    agent, cell, away.facing, return_stream(statement.heading_stream), here, world
                )


def free_cells(domain: ir.Domain, leaving: set[Body], here: Instance) -> list[Cell]:
    """Returns the free cells of the destination's kinds in reading order. The cells of those who are `leaving` are free."""
    assert domain.restriction is None, "a destination is not around anything"
    covered = occupied(here.world, leaving)
    return [cell for cell in cells_of(here.board, domain.var.kinds) if cell not in covered]


def _fitting(
    domain: ir.Domain, free: list[Cell], names: Mapping[str, Value], here: Instance
) -> list[Cell]:
    """Returns those of the free cells that a destination's `where` leaves an agent, in whose instance `names` are known."""
    if domain.where is None:
        return list(free)
    return [
        cell for cell in free if evaluate(domain.where, here.only({**names, domain.var.name: cell}))
    ]


def _enter(
    agent: Body, cell: Cell, facing: Facing | None, stream: int, here: Instance, world: World
) -> None:
    herd_of(agent, world).position[number_of(agent)] = cell
    herd_of(agent, world).away[number_of(agent)] = None
    enter_facing(agent, facing, stream, here, world)


def enter_facing(
    agent: Body, facing: Facing | None, stream: int | None, here: Instance, world: World
) -> None:
    """Turns somebody who has been sent somewhere: in the direction that the statement says, or else in one that is drawn."""
    if facing is None:
        assert stream is not None
        turn(agent, here.word(stream, number_of(agent)) >> 30, world)
    elif facing != "same":
        turn(agent, HEADINGS.index(facing), world)


def _leave(agent: Body, away: Away, world: World) -> None:
    herd_of(agent, world).position[number_of(agent)] = None
    herd_of(agent, world).away[number_of(agent)] = away
