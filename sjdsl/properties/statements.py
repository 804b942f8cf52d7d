"""The statements of a game that change something, each with its guards, and the dependency of checks on them."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from sjdsl.compiler import ir
from sjdsl.properties.effects import Part, reads, reads_and_blocks, written_by

StatementId = tuple[str, str, int]  # (use of a phase in the schedule, file, offset): one statement in one use of a phase
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


def _leaves(body: Iterable[ir.Stmt], label: str, around: tuple[ir.Node, ...]) -> Iterator[LeafStatement]:
    for statement in body:
        match statement:
            case ir.Let():
                around = (*around, statement.value)
            case ir.Draw():
                around = (*around, *ir.children(statement))
            case ir.Each():
                yield from _leaves(statement.body, label, (*around, statement.domain))
            case ir.First():
                yield from _leaves((*statement.body, *statement.otherwise), label, (*around, statement.domain))
            case ir.Pick():
                yield from _leaves((*statement.body, *statement.otherwise), label, (*around, statement.number, statement.domain))
            case ir.Match():
                yield from _leaves(statement.body, label, (*around, statement.left, statement.right))
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


def statements_needed_by(check: ir.Check, game: ir.Game, leaves: Iterable[LeafStatement]) -> frozenset[StatementId]:
    """Returns the statements on which a check depends: those that write what it reads, those that write what these read, and so on.

    A symmetry depends on every statement.
    """
    leaves = tuple(leaves)
    if check.sort == "symmetric":
        return frozenset(leaf.statement_id for leaf in leaves)
    wanted: set[Part] = {part for e in check.values for part in reads_and_blocks(e, game)}
    waiting = {i: set(written_by(leaf.statement)) for i, leaf in enumerate(leaves)}
    found: set[StatementId] = set()
    while True:
        now = [i for i, written in waiting.items() if written & wanted]
        if not now:
            return frozenset(found)
        for i in now:
            del waiting[i]
            found.add(leaves[i].statement_id)
            wanted |= set(_read_by(leaves[i], game))


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
