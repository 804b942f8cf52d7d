"""Interprets `move`.

All members step at once, a collision on a cell is settled at random, and swaps are blocked.
"""

from collections.abc import Mapping

from sjdsl.compiler import ir
from sjdsl.interpreter.bodies import (
    Body,
    heading_of,
    herds,
    is_free,
    number_of,
    occupied,
    turn,
    type_of_body,
    where_is,
)
from sjdsl.interpreter.evaluate import evaluate, is_blocked, members_of
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.shapes import FORWARD
from sjdsl.interpreter.state import HEADINGS, Cell, Mover, World

TURNS = {"turn_left": -1, "turn_right": 1}
STEPS = {"forward": 0, "step_right": 1, "backward": 2, "step_left": 3}


def move(
    entity_type: ir.EntityType,
    ranks: dict[Body, int],
    courses: dict[Body, int | None],
    instance: Instance,
    world: World,
) -> None:
    """Changes places and headings of `world`, which holds those of the snapshot.

    Args:
      sort: the entity type of those who move.
      ranks: of all who move; the largest wins a cell.
      courses: the direction of each mover; agents move as their actions say.
    """
    directions = {
        body: courses[body] if isinstance(body, Mover) else _chosen_direction(body, instance)
        for body in ranks
    }
    targets: dict[Body, Cell] = {}
    for body, direction in directions.items():
        target = _target(body, direction, instance)
        if target is not None:
            targets[body] = target
    _stay_if_swapping(targets, instance.world)
    stay_if_outranked(targets, ranks)
    stay_if_taken(targets, instance.world)
    for body, direction in directions.items():
        if not isinstance(body, Mover):
            turns = TURNS.get(_action(body, instance), 0)
            turn(body, (heading_of(body, instance.world) + turns) % 4, world)
        elif direction is not None:
            turn(body, direction, world)
    herd = herds(world)[entity_type]
    herd.moved = [False for _ in herd.moved]
    for body, target in targets.items():
        herd.position[number_of(body)] = target
        herd.moved[number_of(body)] = True


def course_of(course: ir.Course, mover: Mover, instance: Instance) -> int | None:
    """Returns the direction in which a mover goes; None if it stays."""
    if isinstance(course, ir.Along):
        return HEADINGS.index(evaluate(course.heading, instance))
    directions = [
        direction for direction in range(4) if _is_open(mover, direction, course, instance)
    ]
    if course.goal is not None:
        goals = [cell for cell in _cells_of(course.goal, instance) if cell is not None]
        place = where_is(mover, instance.world)
        assert place is not None
        current = _distance(place, goals, instance)
        distances = {
            direction: _distance(_target(mover, direction, instance) or place, goals, instance)
            for direction in directions
        }
        if course.away:
            directions = [d for d in directions if distances[d] > current]
        else:
            directions = [d for d in directions if distances[d] < current]
    if not directions:
        return None
    direction, _ = instance.take(course.stream, mover.number, directions)
    return direction


def _distance(place: Cell, goals: list[Cell], instance: Instance) -> int:
    """Returns the steps to the nearest goal, 0 without goals."""
    return min((instance.board.steps(place, goal) for goal in goals), default=0)


def _cells_of(domain: ir.Domain, instance: Instance) -> list[Cell | None]:
    """Returns the cells of a domain, or those on which its members stand."""
    return [
        m.member if isinstance(m.member, Cell) else where_is(m.member, instance.world)
        for m in members_of(domain, instance)
    ]


def _is_open(mover: Mover, direction: int, course: ir.Wander, instance: Instance) -> bool:
    """Returns whether the next cell lets the mover in, is free, and isn't one that it avoids."""
    target = _target(mover, direction, instance)
    if target is None or not is_free(target, instance.world):
        return False
    return course.avoided is None or target not in _cells_of(course.avoided, instance)


def _action(agent: int, instance: Instance) -> str:
    return instance.board.game.agents.actions[instance.actions[agent]]


def _chosen_direction(agent: int, instance: Instance) -> int | None:
    """Returns the direction of an agent's step; None if its action isn't a step."""
    direction = STEPS.get(_action(agent, instance))
    if direction is not None and instance.board.game.agents.relative:
        direction = (instance.world.heading[agent] + direction) % 4
    return direction


def _target(body: Body, direction: int | None, instance: Instance) -> Cell | None:
    """Returns the next cell in a direction; None without one, or if a body can't enter it."""
    place = where_is(body, instance.world)
    if place is None or direction is None:
        return None
    rows, cols = FORWARD[direction]
    target = instance.board.at(place.row + rows, place.col + cols)
    if target is None or is_blocked(target, type_of_body(body).plural, body, instance):
        return None
    return target


def _stay_if_swapping(targets: dict[Body, Cell], world: World) -> None:
    """Removes the targets of bodies that would enter each other's cells."""
    places = {body: where_is(body, world) for body in targets}
    swapping = [
        body
        for body, target in targets.items()
        if any(target == places[other] and targets[other] == places[body] for other in targets)
    ]
    for body in swapping:
        del targets[body]


def stay_if_outranked(targets: dict[Body, Cell], ranks: Mapping[Body, int]) -> None:
    """Removes the targets of all but the body with the largest rank, of several with one target."""
    outranked = [
        body
        for body, target in targets.items()
        if any(targets[other] == target and ranks[other] > ranks[body] for other in targets)
    ]
    for body in outranked:
        del targets[body]


def stay_if_taken(targets: dict[Body, Cell], world: World) -> None:
    """Removes targets on which a body stays, even if that body has just lost its own target."""
    while True:
        staying = occupied(world, without=targets)
        stopped = [body for body, target in targets.items() if target in staying]
        if not stopped:
            return
        for body in stopped:
            del targets[body]
