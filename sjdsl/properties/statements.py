"""The statements of a game that change something.

On which of them a check depends, which of them ran, and events that count them.
"""

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field
from itertools import count
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import beginning_phases, contains
from sjdsl.interpreter.account import Account
from sjdsl.properties.effects import Part, reads, reads_and_blocks, written_by

# One statement in one use of a phase: the label of that, then file and offset of the statement.
StatementId = tuple[str, str, int]


@dataclass(frozen=True)
class LeafStatement:
    """A statement without others in it, in one use of its phase.

    around: the domains, guards, chances and values that decide whether, and on whom, the statement
    works; outermost first.
    """

    statement_id: StatementId
    statement: ir.Stmt
    around: tuple[ir.Node, ...]


def statement_id(label: str, statement: ir.Node) -> StatementId:
    """Returns the name of a statement in one use of a phase, the same on every map."""
    origin = statement.origin
    return (label, "", -1) if origin is None else (label, origin.file, origin.start)


def leaf_statements(game: ir.Game) -> tuple[LeafStatement, ...]:
    """Returns the statements that change the state, pay, count or end.

    First those of the phases with which an episode begins, then those of the schedule.
    """
    leaves: list[LeafStatement] = []
    for turn in (*beginning_phases(game), *game.schedule):
        if isinstance(turn, ir.Phase):
            leaves += _leaves(turn.body, turn.label, ())
    return tuple(leaves)


def _leaves(
    body: Iterable[ir.Stmt], label: str, around: tuple[ir.Node, ...]
) -> Iterator[LeafStatement]:
    """Yields the leaves in a body. `around`: what decides whether the body works."""
    for statement in body:
        match statement:
            case ir.Let():
                around = (*around, statement.value)
            case ir.Draw():
                around = (*around, *ir.children(statement))
            case ir.Each() | ir.First():
                yield from _leaves(statement.body, label, (*around, statement.domain))
            case ir.Pick():
                inner = (*statement.body, *statement.otherwise)
                yield from _leaves(inner, label, (*around, statement.number, statement.domain))
            case ir.Match():
                pair = (statement.left, statement.right)
                yield from _leaves(statement.body, label, (*around, *pair))
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
    """Returns the statements on which a check depends.

    Those that write what it reads, those that write what these read, and so on.
    """
    wanted: set[Part] = set()
    for e in check.values:
        wanted |= reads_and_blocks(e, game)
    waiting = list(leaves)
    needed: set[StatementId] = set()
    while True:
        writers = [leaf for leaf in waiting if wanted.intersection(written_by(leaf.statement))]
        if not writers:
            return frozenset(needed)
        waiting = [leaf for leaf in waiting if leaf not in writers]
        for leaf in writers:
            needed.add(leaf.statement_id)
            wanted |= set(_read_by(leaf, game))


def _read_by(leaf: LeafStatement, game: ir.Game) -> Iterator[Part]:
    """Yields what decides whether, where and with which value a statement works."""
    reads_action = False
    moves = False
    for node in (*leaf.around, leaf.statement):
        yield from reads_and_blocks(node, game)
        reads_action = reads_action or contains(node, ir.Chose, ir.ChoseWith)
        moves = moves or contains(node, ir.Move)
    if reads_action or moves:
        for forbid in game.agents.forbids:
            yield from reads(forbid.condition)
    if moves:
        for kind in game.kinds:
            for block in kind.blocks:
                if block.condition is not None:
                    yield from reads_and_blocks(block, game)


def statements_run(accounts: Iterable[Account]) -> set[StatementId]:
    """Returns the statements that ran in a step, or when an episode began."""
    statements: set[StatementId] = set()
    for account in accounts:
        if isinstance(account.turn, ir.Phase):
            label = account.turn.label
            statements |= {statement_id(label, done.statement) for done in account.done}
    return statements


def count_statements(game: ir.Game) -> tuple[ir.Game, dict[str, StatementId]]:
    """Returns the game with an event for each statement, which counts how often it runs.

    The event is tallied just before the statement. Statements of phases in which agents move, and
    of those before the first step, are not counted.

    Returns:
      the changed game, and the statement that each of the new events counts, by the event's name.
    """
    statements = {leaf.statement_id for leaf in leaf_statements(game)}
    counter = _Counter(statements, {event.name for event in game.events})
    schedule: list[ir.Turn] = []
    for turn in game.schedule:
        if isinstance(turn, ir.Phase) and not contains(turn, ir.Move):
            turn = turn.changed(body=counter.with_counts(turn.body, turn.label))
        schedule.append(turn)
    new_events = [ir.Event(name=name, per_agent=False) for name in counter.events]
    changed = game.changed(schedule=tuple(schedule), events=(*game.events, *new_events))
    return changed, counter.events


@dataclass
class _Counter:
    """Adds a `tally` before each statement. events: name -> the statement that it counts."""

    statements: Collection[StatementId]
    taken: set[str]  # names of events
    events: dict[str, StatementId] = field(default_factory=dict)

    def with_counts(self, body: Iterable[ir.Stmt], label: str) -> tuple[ir.Stmt, ...]:
        """Returns the statements of a phase with that label, each with its `tally` before it."""
        result: list[ir.Stmt] = []
        for statement in body:
            name = statement_id(label, statement)
            if name in self.statements and name not in self.events.values():
                event = self._unused_name()
                self.events[event] = name
                result.append(ir.Tally(event=event, origin=statement.origin))
            result.append(self._with_inner_counts(statement, label))
        return tuple(result)

    def _with_inner_counts(self, node: Any, label: str) -> Any:
        """Returns a statement, or a branch of one, with counts in its bodies."""
        changes: dict[str, Any] = {}
        for part in ("body", "otherwise"):
            if body := getattr(node, part, ()):
                changes[part] = self.with_counts(body, label)
        if branches := getattr(node, "branches", ()):
            changes["branches"] = tuple(
                self._with_inner_counts(branch, label) for branch in branches
            )
        return node.changed(**changes) if changes else node

    def _unused_name(self) -> str:
        """Returns a name for a further event that counts how often a statement runs."""
        for number in count(len(self.events)):
            name = f"ran_{number}"
            if name not in self.taken and name not in self.events:
                return name
        raise AssertionError
