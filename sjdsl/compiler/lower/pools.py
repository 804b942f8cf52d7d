"""Pools: the destinations of `send` in a game, numbered; each use of a phase has its own."""

from typing import TypeAlias

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.queries import beginning_phases, body_type
from sjdsl.compiler.lower.writer import Module


class Pool(Record):
    """One destination of one use of a phase; `number` names it in the state of those away."""

    number: int
    send: ir.Send
    phase: str

    @property
    def kinds(self) -> tuple[str, ...]:
        return self.send.domain.var.kinds

    @property
    def entity_type(self) -> ir.EntityType:
        """Agents, or the movers, that are sent."""
        return body_type(self.send.who)


Pools: TypeAlias = dict[str, tuple[Pool, ...]]  # by phase


def all_pools(game: ir.Game) -> Pools:
    """Returns the pools of every phase, numbered through the game."""
    pools: Pools = {}
    number = 0
    for phase in (*beginning_phases(game), *game.schedule):
        if not isinstance(phase, ir.Phase):
            continue
        of_phase: dict[int, Pool] = {}
        for node in ir.walk(phase):
            if isinstance(node, ir.Send) and node.pool not in of_phase:
                of_phase[node.pool] = Pool(number, node, phase.name)
                number += 1
        pools[phase.name] = tuple(of_phase.values())
    return pools


def sends_of(pool: Pool, module: Module) -> list[ir.Send]:
    """Returns all statements that send to a pool."""
    return [s for s in module.sends if s.cell_stream == pool.send.cell_stream]
