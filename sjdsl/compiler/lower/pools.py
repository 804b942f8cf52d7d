"""The pools of a game: destinations of `send`, one for each use of a phase."""

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.ir.queries import body_sort
from sjdsl.compiler.lower.writer import Module


class Pool(Record):
    """One destination of one phase use; `number` names it in the state of those who are away."""

    number: int
    send: ir.Send
    phase: str

    @property
    def kinds(self) -> tuple[str, ...]:
        return self.send.domain.var.kinds

    @property
    def sort(self) -> ir.Sort:
        """The sort of those who are sent."""
        return body_sort(self.send.who)


def all_pools(game: ir.Game) -> dict[str, tuple[Pool, ...]]:
    """Returns the pools of every phase, numbered through the game."""
    pools: dict[str, tuple[Pool, ...]] = {}
    number = 0
    for phase in (game.start, *game.schedule):
        if not isinstance(phase, ir.Phase):
            continue
        found: dict[int, Pool] = {}
        for node in ir.walk(phase):
            if isinstance(node, ir.Send) and node.pool not in found:
                found[node.pool] = Pool(number, node, phase.name)
                number += 1
        pools[phase.name] = tuple(found.values())
    return pools


def sends_of(pool: Pool, module: Module) -> list[ir.Send]:
    """Returns all statements that send to a pool."""
    return [s for s in module.sends if s.cell_stream == pool.send.cell_stream]
