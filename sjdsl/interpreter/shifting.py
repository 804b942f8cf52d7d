"""Interprets `send x by n DIRECTION` and `send x to CELL`.

The target of each body, and the collisions of all who are sent in one phase.
"""

from sjdsl.compiler import ir
from sjdsl.interpreter.bodies import (
    Body,
    heading_of,
    herd_of,
    herds,
    is_free,
    number_of,
    type_of_body,
    where_is,
)
from sjdsl.interpreter.evaluate import cell_of, evaluate, is_blocked
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.movement import stay_if_outranked, stay_if_taken
from sjdsl.interpreter.sending import enter_facing, facing_of
from sjdsl.interpreter.shapes import place_at
from sjdsl.interpreter.state import HEADINGS, Cell, World
from sjdsl.interpreter.writes import Shifting


def make_shifting(agent: Body, statement: ir.Shift, instance: Instance) -> Shifting:
    """Returns where a statement sends a body: to its own cell if the way there is blocked."""
    place = where_is(agent, instance.world)
    facing = facing_of(statement, instance)
    if place is None:
        return Shifting(agent, statement, None, facing)
    if statement.to is not None:
        return Shifting(agent, statement, evaluate(statement.to, instance) or place, facing)
    assert statement.steps is not None
    steps = evaluate(statement.steps, instance)
    heading = _heading(agent, statement, instance)
    target = place
    if heading is not None and steps > 0:
        blocked = type_of_body(agent).plural
        path: list[Cell] = []
        for ahead in range(1, steps + 1):
            cell = instance.board.at(*place_at(place, heading, ahead, 0))
            if cell is None or is_blocked(cell, blocked, agent, instance):
                return Shifting(agent, statement, place, facing)
            path.append(cell)
        # Whether the last cell is free is seen once all are sent.
        if all(is_free(cell, instance.world) for cell in path[:-1]):
            target = path[-1]
    return Shifting(agent, statement, target, facing)


def _heading(agent: Body, statement: ir.Shift, instance: Instance) -> int | None:
    """Returns the direction in which an agent or a mover is sent; None if there is none."""
    if statement.heading is not None:
        return (HEADINGS.index(evaluate(statement.heading, instance)) + statement.quarters) % 4
    assert statement.other is not None
    place = where_is(agent, instance.world)
    other = cell_of(statement.other, instance)
    if place is None or other is None or place == other:
        return None
    rows, cols = instance.board.offset(place, other)
    heading = heading_of(agent, instance.world)
    is_vertical = abs(rows) > abs(cols)
    if abs(rows) == abs(cols):
        is_vertical = heading in (0, 2)
    if is_vertical:
        toward = 0 if rows < 0 else 2
        distance = rows
        size = len(instance.board.game.rows)
    else:
        toward = 3 if cols < 0 else 1
        distance = cols
        size = len(instance.board.game.rows[0])
    if instance.board.game.wraps and 2 * distance == size:  # both ways round are equally long
        if heading % 2 != toward % 2:
            return None
        toward = heading
    return (toward + statement.quarters) % 4


def shift(shifts: list[Shifting], instance: Instance, world: World) -> None:
    """Changes the places of `world`, which has those of the bodies sent by `send` in this phase.

    Each entity type of movers comes in turn, then the agents; those that come later see the new
    places of the others.
    """
    agents, *movers = herds(world)
    for entity_type in (*movers, agents):
        ranks: dict[Body, int] = {}
        targets: dict[Body, Cell] = {}
        of_type = [sent for sent in shifts if type_of_body(sent.agent) == entity_type]
        for sent in of_type:
            number = number_of(sent.agent)
            # The number, which is below 256, decides between equal random bits.
            ranks[sent.agent] = instance.bits(sent.statement.stream, number) & ~0xFF | number
            if sent.target is not None and sent.target != where_is(sent.agent, world):
                targets[sent.agent] = sent.target
        stay_if_outranked(targets, ranks)
        stay_if_taken(targets, world)
        for agent, statement, _, facing in of_type:
            if agent in targets:
                herd_of(agent, world).position[number_of(agent)] = targets[agent]
                enter_facing(agent, facing, statement.heading_stream, instance, world)
