"""The statements of a game that change something: on which of them a check depends, which ran, and how often in the compiled game."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import contains
from sjdsl.interpreter.account import Account
from sjdsl.properties.effects import Part, reads, reads_and_blocks, written_by

StatementId = tuple[
    str, str, int
]  # (use of a phase in the schedule, file, offset): one statement in one use of a phase
STARTING = "start"


@dataclass(frozen=True)
class LeafStatement:
    """A statement without others in it, in one use of its phase.

    around: the domains, guards, chances and values that decide whether, and on whom, the statement works; outermost first.
    """

    statement_id: StatementId
    statement: ir.Stmt
    around: tuple[ir.Node, ...]


def statement_id(label: str, statement: ir.Node) -> StatementId:
    """Returns the name of a statement in one use of a phase, the same on every map."""
    origin = statement.origin
    return (label, "", -1) if origin is None else (label, origin.file, origin.start)


def leaf_statements(game: ir.Game) -> tuple[LeafStatement, ...]:
    """Returns the statements of the phase `start` and of the schedule that change the state, pay, count or end, in that order."""
    found = list(_leaves(game.start.body, STARTING, ()))
    for turn in game.schedule:
        if isinstance(turn, ir.Phase):
            found += _leaves(turn.body, turn.label, ())
    return tuple(found)


def _leaves(
    body: Iterable[ir.Stmt], label: str, around: tuple[ir.Node, ...]
) -> Iterator[LeafStatement]:
    for statement in body:
        match statement:
            case ir.Let():
                around = (*around, statement.value)
            case ir.Draw():
                around = (*around, *ir.children(statement))
            case ir.Each() | ir.First():
                yield from _leaves(statement.body, label, (*around, statement.domain))
            case ir.Pick():
                yield from _leaves(
                    (*statement.body, *statement.otherwise),
                    label,
                    (*around, statement.number, statement.domain),
                )
            case ir.Match():
                yield from _leaves(
                    statement.body, label, (*around, statement.left, statement.right)
                )
            case ir.When() | ir.Chance():
                tests: tuple[ir.Node, ...] = ()
                for branch in statement.branches:
                    tests = (*tests, branch.test)
                    yield from _leaves(branch.body, label, (*around, *tests))
                yield from _leaves(statement.otherwise, label, (*around, *tests))
            case ir.Mark():
                pass  # for the picture only
            case _:
                yield LeafStatement(statement_id(label, statement), statement, around)


def statements_needed_by(
    check: ir.Check, game: ir.Game, leaves: Iterable[LeafStatement]
) -> frozenset[StatementId]:
    """Returns the statements on which a check depends: those that write what it reads, those that write what these read, and so on."""
    wanted: set[Part] = {part for e in check.values for part in reads_and_blocks(e, game)}
    waiting, found = list(leaves), set[StatementId]()
    while now := [leaf for leaf in waiting if wanted.intersection(written_by(leaf.statement))]:
        waiting = [leaf for leaf in waiting if leaf not in now]
        found |= {leaf.statement_id for leaf in now}
        wanted |= {part for leaf in now for part in _read_by(leaf, game)}
    return frozenset(found)


def _read_by(leaf: LeafStatement, game: ir.Game) -> Iterator[Part]:
    """Yields what decides whether, where and with which value a statement works."""
    nodes = [n for node in (*leaf.around, leaf.statement) for n in ir.walk(node)]
    for node in (*leaf.around, leaf.statement):
        yield from reads_and_blocks(node, game)
    if any(isinstance(n, ir.Chose | ir.ChoseWith | ir.Move) for n in nodes):
        for forbid in game.agents.forbids:
            yield from reads(forbid.condition)
    if any(isinstance(n, ir.Move) for n in nodes):
        for block in (b for kind in game.kinds for b in kind.blocks if b.condition is not None):
            yield from reads_and_blocks(block, game)


def statements_run(accounts: Iterable[Account]) -> set[StatementId]:
    """Returns the statements that ran in a step, or in the phase `start`."""
    found = set[StatementId]()
    for account in accounts:
        if isinstance(account.turn, ir.Phase):
            label = STARTING if account.turn.name == STARTING else account.turn.label
            found |= {statement_id(label, done.statement) for done in account.done}
    return found


def count_statements(game: ir.Game) -> tuple[ir.Game, dict[str, StatementId]]:
    """Returns the game with an event beside each of its statements, and the statement that each event counts, by its name.

    Nothing is counted in `start`, and where agents move.
    """
    statements = {leaf.statement_id for leaf in leaf_statements(game)}
    taken, events = {event.name for event in game.events}, dict[str, StatementId]()

    def counted(body: tuple[ir.Stmt, ...], label: str) -> tuple[ir.Stmt, ...]:
        found: list[ir.Stmt] = []
        for statement in body:
            name = statement_id(label, statement)
            if name in statements and name not in events.values():
                event = next(
                    f"ran_{i}"
                    for i in range(len(events), len(events) + len(taken) + 1)
                    if f"ran_{i}" not in taken
                )
                events[event] = name
                taken.add(event)
                found.append(ir.Tally(event=event, origin=statement.origin))
            found.append(inside(statement, label))
        return tuple(found)

    def inside(node: Any, label: str) -> Any:
        """Returns a statement, or a branch of one, with counts in it."""
        bodies = {
            part: counted(getattr(node, part), label)
            for part in ("body", "otherwise")
            if getattr(node, part, ())
        }
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
    return game.model_copy(update={"schedule": schedule, "events": (*game.events, *more)}), events
