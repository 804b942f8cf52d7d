"""Interprets `send x by n DIRECTION` and `send x to CELL`: the way of each agent, and all who are sent in one phase settled together."""

from sjdsl.compiler import ir
from sjdsl.interpreter.bodies import (
    Body,
    heading_of,
    herd_of,
    herds,
    is_free,
    number_of,
    sort_of_body,
    where_is,
)
from sjdsl.interpreter.evaluate import cell_of, evaluate, is_blocked
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.movement import stay_if_outranked, stay_if_taken
from sjdsl.interpreter.sending import enter_facing
from sjdsl.interpreter.shapes import place_at
from sjdsl.interpreter.state import HEADINGS, World
from sjdsl.interpreter.writes import Shifting


def shifting(agent: Body, statement: ir.Shift, here: Instance) -> Shifting:
    """Returns where a statement sends an agent or a mover; to its own cell if the way there is not free."""
    place = where_is(agent, here.world)
    if statement.to is not None:
        return Shifting(agent, statement, place and (evaluate(statement.to, here) or place))
    assert statement.steps is not None
    steps = evaluate(statement.steps, here)
    heading = _heading(agent, statement, here)
    target = place
    if place is not None and heading is not None and steps > 0:
        what = sort_of_body(agent).plural
        way = [here.board.at(*place_at(place, heading, ahead, 0)) for ahead in range(1, steps + 1)]
        free = all(cell is not None and not is_blocked(cell, what, agent, here) for cell in way)
        if free and all(cell is not None and is_free(cell, here.world) for cell in way[:-1]):
            target = way[-1]
    return Shifting(agent, statement, target)


def _heading(agent: Body, statement: ir.Shift, here: Instance) -> int | None:
    """Returns which way an agent or a mover is sent; None where there is no such way."""
    if statement.heading is not None:
        return (HEADINGS.index(evaluate(statement.heading, here)) + statement.quarters) % 4
    assert statement.other is not None
    place, other = where_is(agent, here.world), cell_of(statement.other, here)
    if place is None or other is None or place == other:
        return None
    rows, cols = here.board.apart(place, other)
    looks = heading_of(agent, here.world)
    upright = looks in (0, 2) if abs(rows) == abs(cols) else abs(rows) > abs(cols)
    toward = (0 if rows < 0 else 2) if upright else (3 if cols < 0 else 1)
    if here.board.game.wraps and 2 * (rows if upright else cols) == len(
        here.board.game.rows if upright else here.board.game.rows[0]
    ):
        if looks % 2 != toward % 2:  # both ways round are equally long, and it looks across them
            return None
        toward = looks
    return (toward + statement.quarters) % 4


def shift(shifts: list[Shifting], here: Instance, world: World) -> None:
    """Changes the places of `world`, in which who is sent elsewhere in this phase has its new place already.

    Each sort of movers in turn, then the agents: they find the others where these then are.
    """
    agents, *movers = herds(world)
    for sort in (*movers, agents):
        own = [s for s in shifts if sort_of_body(s.agent) == sort]
        ranks = {
            s.agent: here.word(s.statement.stream, number_of(s.agent)) & ~0xFF | number_of(s.agent)
            for s in own
        }
        targets = {
            s.agent: s.target
            for s in own
            if s.target is not None and s.target != where_is(s.agent, world)
        }
        stay_if_outranked(targets, ranks)
        stay_if_taken(targets, world)
        for sent in (s for s in own if s.agent in targets):
            herd_of(sent.agent, world).position[number_of(sent.agent)] = sent.target
            enter_facing(
                sent.agent, sent.statement.facing, sent.statement.heading_stream, here, world
            )
