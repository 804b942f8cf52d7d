"""Interprets `move`: all members step at once, a collision on a cell is settled at random, and swaps are blocked."""

from collections.abc import Mapping

from sjdsl.compiler import ir
from sjdsl.interpreter.bodies import (
    Body,
    heading_of,
    herds,
    is_free,
    number_of,
    occupied,
    sort_of_body,
    turn,
    where_is,
)
from sjdsl.interpreter.evaluate import evaluate, is_blocked, members_of
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.shapes import FORWARD
from sjdsl.interpreter.state import HEADINGS, Cell, Mover, World

TURNS = {"turn_left": -1, "turn_right": 1}
STEPS = {"forward": 0, "step_right": 1, "backward": 2, "step_left": 3}


def move(
    sort: ir.Sort,
    ranks: dict[Body, int],
    courses: dict[Body, int | None],
    here: Instance,
    world: World,
) -> None:
    """Changes places and headings of `world`, which holds the snapshot's.

    sort: of those who move. ranks: of those who move, the largest wins a cell. courses: of movers, which way each goes; agents go where they chose.
    """
    ways = {
        body: courses[body] if isinstance(body, Mover) else _chosen_way(body, here)
        for body in ranks
    }
    targets = {
        body: target
        for body, way in ways.items()
        if (target := _target(body, way, here)) is not None
    }
    place = {body: where_is(body, here.world) for body in targets}
    for a in [
        a
        for a in targets
        if any(targets[a] == place[b] and targets[b] == place[a] for b in targets)
    ]:  # nobody swaps
        del targets[a]
    stay_if_outranked(targets, ranks)
    stay_if_taken(targets, here.world)
    for body in ranks:
        if not isinstance(body, Mover):
            turn(
                body, (heading_of(body, here.world) + TURNS.get(_action(body, here), 0)) % 4, world
            )
        elif (way := ways[body]) is not None:
            turn(body, way, world)
    herd = herds(world)[sort]
    herd.moved = [False for _ in herd.moved]
    for body, target in targets.items():
        herd.position[number_of(body)], herd.moved[number_of(body)] = target, True


def course_of(course: ir.Course, mover: Mover, here: Instance) -> int | None:
    """Returns the direction in which a mover goes; None if there is no way that it wants to go."""
    if isinstance(course, ir.Along):
        return HEADINGS.index(evaluate(course.heading, here))
    open_ = [way for way in range(4) if _is_open(mover, way, course, here)]
    goals = (
        []
        if course.goal is None
        else [cell for cell in _cells_of(course.goal, here) if cell is not None]
    )
    if course.goal is not None:
        place = where_is(mover, here.world)
        assert place is not None
        now = min((here.board.steps(place, cell) for cell in goals), default=0)
        there = {way: _target(mover, way, here) or place for way in open_}
        gained = {
            way: min((here.board.steps(there[way], cell) for cell in goals), default=0) - now
            for way in open_
        }
        open_ = [way for way in open_ if (gained[way] > 0 if course.away else gained[way] < 0)]
    return here.take(course.stream, mover.number, open_)[0] if open_ else None


def _cells_of(domain: ir.Domain, here: Instance) -> list[Cell | None]:
    """Returns the cells of a domain, or those on which its members stand."""
    return [
        m.member if isinstance(m.member, Cell) else where_is(m.member, here.world)
        for m in members_of(domain, here)
    ]


def _is_open(mover: Mover, way: int, course: ir.Wander, here: Instance) -> bool:
    """Returns whether a neighbouring cell lets the mover in, is free, and is none that it avoids."""
    target = _target(mover, way, here)
    if target is None or not is_free(target, here.world):
        return False
    return course.avoided is None or target not in _cells_of(course.avoided, here)


def _action(agent: int, here: Instance) -> str:
    return here.board.game.agents.actions[here.actions[agent]]


def _chosen_way(agent: int, here: Instance) -> int | None:
    """Returns the direction in which an agent has chosen to go, None if it has not."""
    direction = STEPS.get(_action(agent, here))
    if direction is not None and here.board.game.agents.relative:
        direction = (here.world.heading[agent] + direction) % 4
    return direction


def _target(body: Body, way: int | None, here: Instance) -> Cell | None:
    """Returns the cell that an agent or a mover wants to enter, None if it does not want to or can not."""
    place = where_is(body, here.world)
    if place is None or way is None:
        return None
    target = here.board.at(place.row + FORWARD[way][0], place.col + FORWARD[way][1])
    return (
        None
        if target is None or is_blocked(target, sort_of_body(body).plural, body, here)
        else target
    )


def stay_if_outranked(targets: dict[Body, Cell], ranks: Mapping[Body, int]) -> None:
    """Of several who want one cell, the one with the largest rank may enter."""
    for body in [
        a for a in targets if any(targets[b] == targets[a] and ranks[b] > ranks[a] for b in targets)
    ]:
        del targets[body]


def stay_if_taken(targets: dict[Body, Cell], world: World) -> None:
    """Nobody may enter a cell where somebody stays, which may be one who has just been kept from moving."""
    while True:
        staying = occupied(world, without=targets)
        stopped = [body for body, target in targets.items() if target in staying]
        if not stopped:
            return
        for body in stopped:
            del targets[body]
