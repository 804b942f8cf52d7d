"""Interprets `send` and `remove`.

A random free cell, a delay away from the map, and the respawn of agents at a `tick`.
"""

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
    turn,
    type_of_body,
)
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import HEADINGS, Away, Cell, Facing, Pool, Value, World
from sjdsl.interpreter.threefry import return_stream
from sjdsl.interpreter.writes import Sending


def send(phase: str, sends: list[Sending], instance: Instance, world: World) -> None:
    """Changes the places of `world`, which holds those of the snapshot.

    Pool by pool, in each pool in the order of numbers.

    Args:
      phase: its name.
    """
    entered: set[Cell] = set()  # in this phase; pools may share cells
    for pool in sorted({sending.send.pool for sending in sends}):
        of_pool = [sending for sending in sends if sending.send.pool == pool]
        of_pool.sort(key=lambda sending: number_of(sending.agent))
        domain = of_pool[0].send.domain
        stream = of_pool[0].send.cell_stream
        # A body that may have to stay doesn't make room for others.
        leaving = set() if _may_stay(stream, instance.board) else {s.agent for s in of_pool}
        free = [cell for cell in free_cells(domain, leaving, instance) if cell not in entered]
        # Whether the cells that fit differ from agent to agent.
        is_individual = any(variables_around(s.domain) for s in _sends_to(stream, instance.board))
        if not is_individual:
            free = _cells_that_fit(domain, free, {}, instance)
        for agent, statement, ticks, facing, names in of_pool:
            fitting = list(free)
            if is_individual:
                fitting = _cells_that_fit(statement.domain, free, names, instance)
            if ticks > 0:
                _leave(agent, Away(ticks, Pool(phase, pool), facing), world)
            elif fitting:
                cell, _ = instance.take(stream, number_of(agent), fitting)
                free.remove(cell)
                entered.add(cell)
                _enter(agent, cell, facing, statement.heading_stream, instance, world)
            else:
                assert statement.stay, _no_room(agent, statement)


def facing_of(statement: ir.Send | ir.Shift, instance: Instance) -> Facing | None:
    """Returns which way a statement makes those face whom it sends; None: any way."""
    if statement.way is None:
        return statement.facing
    facing: Facing = evaluate(statement.way, instance)
    return facing


@lru_cache(maxsize=256)
def _sends_to(cell_stream: int, board: Board) -> tuple[ir.Send, ...]:
    """Returns the statements that send to one pool."""
    return tuple(
        node
        for node in ir.walk(board.game)
        if isinstance(node, ir.Send) and node.cell_stream == cell_stream
    )


def _may_stay(cell_stream: int, board: Board) -> bool:
    """Returns whether any statement that sends to this pool says `otherwise stay`."""
    return any(send.stay for send in _sends_to(cell_stream, board))


def _no_room(agent: Body, statement: ir.Send) -> str:
    """Returns a message for maps without enough cells, which the compiler refuses.

    A scene may use one.
    """
    kinds = " or ".join(statement.domain.var.kinds)
    return (
        f"{type_of_body(agent).name} {number_of(agent)} is sent to {kinds}, where no cell is free"
    )


def remove(agent: Body, world: World) -> None:
    """Takes an agent or a mover off the map for good."""
    _leave(agent, Away(0, None, None), world)


def bring_back(instance: Instance, world: World) -> None:
    """Counts down one tick for all who are away.

    At the last one they come back, or wait for a free cell.
    """
    due: dict[Pool, list[Body]] = {}
    for agent in bodies(instance.world):
        away = away_of(agent, instance.world)
        if away is not None and away.ticks == 1 and away.pool is not None:
            due.setdefault(away.pool, []).append(agent)
        elif away is not None and away.ticks > 1:
            herd_of(agent, world).away[number_of(agent)] = away._replace(ticks=away.ticks - 1)
    for pool, statement in instance.board.pools.items():
        if pool not in due:
            continue
        may_stay = _may_stay(statement.cell_stream, instance.board)
        cell_stream = return_stream(statement.cell_stream)
        heading_stream = return_stream(statement.heading_stream)
        filled = occupied(world)
        free = [c for c in free_cells(statement.domain, set(), instance) if c not in filled]
        for agent in due[pool]:
            away = away_of(agent, instance.world)
            # The only variable that the destination may read is the agent that comes back.
            names = {variable.name: agent for variable in variables_around(statement.domain)}
            fitting = _cells_that_fit(statement.domain, free, names, instance)
            assert fitting or may_stay, _no_room(agent, statement)
            if fitting and away is not None:
                cell, _ = instance.take(cell_stream, number_of(agent), fitting)
                free.remove(cell)
                _enter(agent, cell, away.facing, heading_stream, instance, world)


def free_cells(domain: ir.Domain, leaving: set[Body], instance: Instance) -> list[Cell]:
    """Returns the free cells of the destination's kinds in reading order.

    The cells of those who are `leaving` are free.
    """
    assert domain.restriction is None, "a destination is not around anything"
    covered = occupied(instance.world, leaving)
    return [cell for cell in cells_of(instance.board, domain.var.kinds) if cell not in covered]


def _cells_that_fit(
    domain: ir.Domain, free: list[Cell], names: Mapping[str, Value], instance: Instance
) -> list[Cell]:
    """Returns the free cells that pass the `where` of a destination. It may read `names`."""
    if domain.where is None:
        return list(free)
    return [
        cell
        for cell in free
        if evaluate(domain.where, instance.only({**names, domain.var.name: cell}))
    ]


def _enter(
    agent: Body, cell: Cell, facing: Facing | None, stream: int, instance: Instance, world: World
) -> None:
    """Puts a body on a cell. `stream`: of its heading, if `facing` is None."""
    herd_of(agent, world).position[number_of(agent)] = cell
    herd_of(agent, world).away[number_of(agent)] = None
    enter_facing(agent, facing, stream, instance, world)


def enter_facing(
    agent: Body, facing: Facing | None, stream: int | None, instance: Instance, world: World
) -> None:
    """Turns a body that has been sent: as the statement says, or else at random."""
    if facing is None:
        assert stream is not None
        turn(agent, instance.bits(stream, number_of(agent)) >> 30, world)
    elif facing != "same":
        turn(agent, HEADINGS.index(facing), world)


def _leave(agent: Body, away: Away, world: World) -> None:
    """Takes a body off the map."""
    herd_of(agent, world).position[number_of(agent)] = None
    herd_of(agent, world).away[number_of(agent)] = away
