"""Interprets `send x by n DIRECTION` and `send x to CELL`: the way of each agent, and all who are sent in one phase settled together."""

from sjdsl.compiler import ir
from sjdsl.interpreter.evaluate import cell_of, evaluate, is_blocked
from sjdsl.interpreter.instance import Instance
from sjdsl.interpreter.members import agent_on
from sjdsl.interpreter.shapes import cell_at
from sjdsl.interpreter.state import HEADINGS, World
from sjdsl.interpreter.writes import Shifting


def shifting(agent: int, statement: ir.Shift, here: Instance) -> Shifting:
    """Returns where a statement sends an agent; to its own cell if the way there is not free."""
    place = here.world.position[agent]
    if statement.to is not None:
        return Shifting(agent, statement, place and (evaluate(statement.to, here) or place))
    assert statement.steps is not None
    steps = evaluate(statement.steps, here)
    heading = _heading(agent, statement, here)
    target = place
    if place is not None and heading is not None and steps > 0:
        way = [cell_at(place, heading, ahead, 0) for ahead in range(1, steps + 1)]
        free = all(cell in here.board.kind_of and not is_blocked(cell, "agents", agent, here) for cell in way)
        if free and all(agent_on(cell, here.world) is None for cell in way[:-1]):
            target = way[-1]
    return Shifting(agent, statement, target)


def _heading(agent: int, statement: ir.Shift, here: Instance) -> int | None:
    """Returns which way an agent is sent; None where there is no such way."""
    if statement.heading is not None:
        return (HEADINGS.index(evaluate(statement.heading, here)) + statement.quarters) % 4
    assert statement.other is not None
    place, other = here.world.position[agent], cell_of(statement.other, here)
    if place is None or other is None or place == other:
        return None
    rows, cols = other.row - place.row, other.col - place.col
    upright = here.world.heading[agent] in (0, 2) if abs(rows) == abs(cols) else abs(rows) > abs(cols)
    toward = (0 if rows < 0 else 2) if upright else (3 if cols < 0 else 1)
    return (toward + statement.quarters) % 4


def shift(shifts: list[Shifting], here: Instance, world: World) -> None:
    """Changes the places of `world`, in which who is sent elsewhere in this phase has its new place already.

    Of several who want one cell, one drawn by lot may enter; nobody may enter a cell whose agent stays.
    """
    ranks = {s.agent: here.word(s.statement.stream, s.agent) & ~0xFF | s.agent for s in shifts}
    goes = {s.agent: s for s in shifts if s.target is not None and s.target != world.position[s.agent]}
    outranked = [a for a in goes if any(goes[b].target == goes[a].target and ranks[b] > ranks[a] for b in goes)]
    for agent in outranked:
        del goes[agent]
    while True:
        staying = {cell for agent, cell in enumerate(world.position) if agent not in goes}
        stopped = [agent for agent in goes if goes[agent].target in staying]
        if not stopped:
            break
        for agent in stopped:
            del goes[agent]
    for agent, sent in goes.items():
        world.position[agent] = sent.target
        match sent.statement.facing:
            case "same":
                pass
            case None:
                assert sent.statement.heading_stream is not None
                world.heading[agent] = here.word(sent.statement.heading_stream, agent) >> 30
            case facing:
                world.heading[agent] = HEADINGS.index(facing)
