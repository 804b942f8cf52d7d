"""Policies of `expect` on the interpreter: `random`, `never(…)`, `seek …` and those of the file, each with two random numbers a step."""

from collections.abc import Sequence

from sjdsl.compiler import ir
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.bodies import where_is
from sjdsl.interpreter.evaluate import members_of
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import Cell, World
from sjdsl.policies import interpreted
from sjdsl.properties.shortest_paths import FAR, ShortestPaths, shortest_paths_of

WANDERS = 8  # one move in so many of a seeking agent is random, so that two that meet in a passage part again


def allowed_by(policy: ir.Policy, game: ir.Game) -> tuple[int, ...]:
    """Returns the actions among which `random` and `never` choose, all equally likely; `stay` if none is left."""
    left = tuple(a for a in range(len(game.agents.actions)) if a not in policy.actions)
    return left or (game.agents.actions.index("stay"),)


def choose(policy: ir.Policy, game: ir.Game, world: World, agent: int, bits: tuple[int, int]) -> int:
    """Returns what an agent with this policy does in a state."""
    if policy.name == "scripted":
        return interpreted.choose(policy_named(game, policy.scripted), game, world, agent, bits)
    if policy.domain is None:
        actions = allowed_by(policy, game)
        return actions[bits[0] * len(actions) >> 32]
    paths = shortest_paths_of(game)
    wandering = bits[1] * WANDERS >> 32 == 0
    cell, stay = world.position[agent], game.agents.actions.index("stay")
    if cell is None or not paths.moves:
        return stay
    wanted = () if wandering else _cells_of(policy.domain, game, world, agent)
    move = towards(paths, node_of(paths, cell, world.heading[agent]), [c.row * paths.width + c.col for c in wanted])
    if move is not None:
        return stay if move < 0 else move
    return paths.moves[bits[0] * len(paths.moves) >> 32]


def policy_named(game: ir.Game, name: str) -> ir.ScriptedPolicy:
    """Returns a policy that the game's file declares."""
    return next(policy for policy in game.policies if policy.name == name)


def node_of(paths: ShortestPaths, cell: Cell, heading: int) -> int:
    """Returns the node of an agent."""
    return (cell.row * paths.width + cell.col) * 4 + heading


def towards(paths: ShortestPaths, node: int, cells: Sequence[int]) -> int | None:
    """Returns the first move of a shortest path to the nearest of the cells, -1 on the spot, None if no path leads to any.

    Of cells equally near the first counts, of moves equally good the first in the order of `acts`.
    """
    here = paths.column(node)
    distances = [int(paths.distance[cell, here]) for cell in cells]
    nearest = min(distances, default=FAR)
    if nearest == FAR:
        return None
    if nearest == 0:
        return -1
    target = cells[distances.index(nearest)]
    after = [int(paths.distance[target, paths.column(int(n))]) for n in paths.after[node]]
    return paths.moves[after.index(min(after))]


def _cells_of(domain: ir.Domain, game: ir.Game, world: World, agent: int) -> list[Cell]:
    """Returns the cells of the members of a domain, for the agent that walks, in the order of their numbers."""
    here = Instance(board_of(game), world, names={"agent": agent})
    found = [m.member for m in members_of(domain, here)]
    cells = [m if isinstance(m, Cell) else where_is(m, world) for m in found]
    return [cell for cell in cells if cell is not None]
