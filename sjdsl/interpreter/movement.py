"""Interprets `move`: all agents step at once, a collision on a cell is settled at random, and swaps are blocked."""

from sjdsl.interpreter.evaluate import is_blocked
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.shapes import FORWARD
from sjdsl.interpreter.state import Cell, World

_TURNS = {"turn_left": -1, "turn_right": 1}
_STEPS = {"forward": 0, "step_right": 1, "backward": 2, "step_left": 3}


def move(movers: dict[int, int], here: Instance, world: World) -> None:
    """Changes places and headings of `world`, which holds the snapshot's. `movers`: agent -> rank, the largest wins a cell."""
    targets = {agent: target for agent in movers if (target := _target(agent, here)) is not None}
    _stay_if_swapping(targets, here)
    _stay_if_outranked(targets, movers)
    _stay_if_taken(targets, here)
    for agent in movers:
        world.heading[agent] = (world.heading[agent] + _TURNS.get(_action(agent, here), 0)) % 4
    for agent, target in targets.items():
        world.position[agent] = target
    world.moved = [agent in targets for agent in range(here.board.agents)]


def _action(agent: int, here: Instance) -> str:
    return here.board.game.agents.actions[here.actions[agent]]


def _target(agent: int, here: Instance) -> Cell | None:
    """Returns the cell the agent wants to enter, None if it does not want to or can not."""
    place, direction = here.world.position[agent], _STEPS.get(_action(agent, here))
    if place is None or direction is None:
        return None
    if here.board.game.agents.relative:
        direction = (here.world.heading[agent] + direction) % 4
    target = Cell(place.row + FORWARD[direction][0], place.col + FORWARD[direction][1])
    if target not in here.board.kind_of or is_blocked(target, "agents", agent, here):
        return None
    return target


def _stay_if_swapping(targets: dict[int, Cell], here: Instance) -> None:
    place = here.world.position
    swapping = [a for a in targets if any(targets[a] == place[b] and targets[b] == place[a] for b in targets)]
    for agent in swapping:
        del targets[agent]


def _stay_if_outranked(targets: dict[int, Cell], ranks: dict[int, int]) -> None:
    outranked = [a for a in targets if any(targets[b] == targets[a] and ranks[b] > ranks[a] for b in targets)]
    for agent in outranked:
        del targets[agent]


def _stay_if_taken(targets: dict[int, Cell], here: Instance) -> None:
    while True:
        staying = {cell for agent, cell in enumerate(here.world.position) if agent not in targets}
        stopped = [agent for agent in targets if targets[agent] in staying]
        if not stopped:
            return
        for agent in stopped:
            del targets[agent]
