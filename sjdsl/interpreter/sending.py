"""Agents sent somewhere: the free cells of a destination in random order, leaving for a while, coming back at a `tick`."""

from sjdsl.compiler import ir
from sjdsl.interpreter.board import cells_of
from sjdsl.interpreter.draws import return_stream
from sjdsl.interpreter.evaluate import evaluate
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import HEADINGS, Away, Cell, Facing, Pool, World
from sjdsl.interpreter.writes import Sending


def send(phase: str, sends: list[Sending], here: Instance, world: World) -> None:
    """Changes the places of `world`, which holds the snapshot's: pool by pool, in each pool in id order. `phase`: its name."""
    for pool in sorted({s.send.pool for s in sends}):
        together = sorted((s for s in sends if s.send.pool == pool), key=lambda s: s.agent)
        order = together[0].send.order_stream
        # who may have to stay does not make room for others
        leaving = set() if _may_stay(order, here) else {s.agent for s in together}
        free = ranked_cells(together[0].send.domain, order, leaving, here)
        for agent, sentence, ticks in together:
            if ticks > 0:
                _leave(agent, Away(ticks, Pool(phase, pool), sentence.facing), world)
            elif free:
                _enter(agent, free.pop(0), sentence.facing, sentence.heading_stream, here, world)
            else:
                assert sentence.stay, f"no free cell for agent {agent}"


def _may_stay(order_stream: int, here: Instance) -> bool:
    """Returns whether any sentence that sends to this pool says `otherwise stay`."""
    sends = (n for n in ir.walk(here.board.game) if isinstance(n, ir.Send))
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
        sentence = here.board.pools[pool]
        # Two pools may share cells: what an earlier one filled is not free any more.
        taken = {cell for cell in world.position if cell is not None}
        free = [c for c in ranked_cells(sentence.domain, return_stream(sentence.order_stream), set(), here) if c not in taken]
        for agent in due[pool]:
            away = here.world.away[agent]
            if free and away is not None:
                _enter(agent, free.pop(0), away.facing, return_stream(sentence.heading_stream), here, world)


def ranked_cells(domain: ir.Domain, stream: int, leaving: set[int], here: Instance) -> list[Cell]:
    """Returns the destination's free cells in their random order. The cells of `leaving` agents are free."""
    assert domain.place is None, "a destination is not around anything"
    taken = {cell for agent, cell in enumerate(here.world.position) if agent not in leaving}
    ranks: dict[Cell, tuple[int, int]] = {}
    for number, cell in enumerate(cells_of(here.board, domain.var.kinds)):
        where = domain.where is None or evaluate(domain.where, here.only({domain.var.name: cell}))
        if where and cell not in taken:
            ranks[cell] = (-(here.word(stream, number) >> 1), number)
    return sorted(ranks, key=lambda cell: ranks[cell])


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
