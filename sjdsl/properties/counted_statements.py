"""A game that counts how often its statements run, so that compiled episodes tell which of them ran."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import contains
from sjdsl.properties.statements import StatementId, statement_id


@dataclass(frozen=True)
class CountedGame:
    """A game with an event for each counted statement, beside the game's own. events: the statement that each stands for, by name."""

    game: ir.Game
    events: Mapping[str, StatementId]


def count_statements(game: ir.Game, statements: Collection[StatementId]) -> CountedGame:
    """Returns the game with a count beside each of some statements; none in `start`, where nothing is counted, and where agents move."""
    taken, events = {event.name for event in game.events}, dict[str, StatementId]()

    def counted(body: tuple[ir.Stmt, ...], label: str) -> tuple[ir.Stmt, ...]:
        found: list[ir.Stmt] = []
        for statement in body:
            name = statement_id(label, statement)
            if name in statements and name not in events.values():
                event = next(f"ran_{i}" for i in range(len(events), len(events) + len(taken) + 1) if f"ran_{i}" not in taken)
                events[event] = name
                taken.add(event)
                found.append(ir.Tally(event=event, origin=statement.origin))
            found.append(inside(statement, label))
        return tuple(found)

    def inside(node: Any, label: str) -> Any:
        """Returns a statement, or a branch of one, with counts in it."""
        bodies = {part: counted(getattr(node, part), label) for part in ("body", "otherwise") if getattr(node, part, ())}
        if branches := getattr(node, "branches", ()):
            bodies["branches"] = tuple(inside(branch, label) for branch in branches)
        return node.model_copy(update=bodies) if bodies else node

    schedule = tuple(
        turn.model_copy(update={"body": counted(turn.body, turn.label)})
        if isinstance(turn, ir.Phase) and not contains(turn, ir.Move)
        else turn
        for turn in game.schedule
    )
    more = tuple(ir.Event(name=name, per_agent=False) for name in events)
    return CountedGame(game.model_copy(update={"schedule": schedule, "events": (*game.events, *more)}), events)
