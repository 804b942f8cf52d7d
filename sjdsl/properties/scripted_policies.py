"""Scripted policies on the interpreter: `random`, `never(…)`, `seek …`, each with two words of luck a step."""

from collections.abc import Sequence

from sjdsl.compiler import ir
from sjdsl.interpreter import members
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.state import Cell, World
from sjdsl.properties.shortest_paths import FAR, Ways, ways_of

WANDERS = 8  # a seeker takes one random move in so many, so that two who meet in a passage part again


def allowed_by(policy: ir.Policy, game: ir.Game) -> tuple[int, ...]:
    """Returns the actions among which `random` and `never` choose, all equally likely; `stay` if none is left."""
    left = tuple(a for a in range(len(game.agents.actions)) if a not in policy.actions)
    return left or (game.agents.actions.index("stay"),)


def choose(policy: ir.Policy, game: ir.Game, world: World, agent: int, words: tuple[int, int]) -> int:
    """Returns what an agent with this policy does in a state."""
    if policy.domain is None:
        actions = allowed_by(policy, game)
        return actions[words[0] * len(actions) >> 32]
    ways = ways_of(game)
    wandering = words[1] * WANDERS >> 32 == 0
    place, stay = world.position[agent], game.agents.actions.index("stay")
    if place is None or not ways.moves:
        return stay
    wanted = () if wandering else _cells_of(policy.domain, game, world, agent)
    way = towards(ways, node_of(ways, place, world.heading[agent]), [c.row * ways.width + c.col for c in wanted])
    if way is not None:
        return stay if way < 0 else way
    return ways.moves[words[0] * len(ways.moves) >> 32]


def node_of(ways: Ways, place: Cell, heading: int) -> int:
    """Returns the node of an agent."""
    return (place.row * ways.width + place.col) * 4 + heading


def towards(ways: Ways, node: int, cells: Sequence[int]) -> int | None:
    """Returns the first move of a shortest way to the nearest of the cells, -1 on the spot, None if no way leads to any.

    Of cells equally near the first counts, of moves equally good the first in the order of `acts`.
    """
    here = ways.column(node)
    distances = [int(ways.distance[cell, here]) for cell in cells]
    nearest = min(distances, default=FAR)
    if nearest == FAR:
        return None
    if nearest == 0:
        return -1
    target = cells[distances.index(nearest)]
    after = [int(ways.distance[target, ways.column(int(n))]) for n in ways.after[node]]
    return ways.moves[after.index(min(after))]


def _cells_of(domain: ir.Domain, game: ir.Game, world: World, agent: int) -> list[Cell]:
    """Returns where the members of a domain are, for the agent that walks, in the order of their numbers."""
    here = Instance(board_of(game), world, names={"agent": agent})
    found = [m.member for m in members.found(domain, here)]
    cells = [world.position[m] if isinstance(m, int) else m for m in found]
    return [cell for cell in cells if cell is not None]
