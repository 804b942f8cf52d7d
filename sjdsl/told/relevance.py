"""The rules that can matter to a player: what only feeds metrics, or counts events that agents don't
see, is left out.
"""

from dataclasses import dataclass
from functools import partial
from typing import assert_never

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.tree import rewrite
from sjdsl.compiler.ir.queries import beginning_phases, written_field, written_keys
from sjdsl.compiler.lower.cell_appearance import seen_marks

FieldName = tuple[str, str, str]  # what holds it, the name of that, its own name


@dataclass(frozen=True)
class Relevant:
    """What of a game can matter to a player.

    game: without statements that change nothing an agent sees, does or gets.
    fields: those that such statements, or what agents see and may do, depend on.
    """

    game: ir.Game
    fields: frozenset[FieldName]

    def has(self, field: ir.VarField) -> bool:
        return (field.held_by.what, field.held_by.name, field.name) in self.fields


def relevant(game: ir.Game) -> Relevant:
    """Returns what of a game can matter to a player."""
    game = game.model_copy(update={"checks": (), "measures": (), "policies": (), "scenarios": ()})
    game = rewrite(game, partial(_without_unseen, {e.name for e in game.events if e.shown}))
    outside = (*game.observables, *game.hidden, *game.agents.forbids, *game.agents.blocks)
    blocks = [block for kind in game.kinds for block in kind.blocks]
    read: set[FieldName] = set()
    for node in (*outside, *blocks, game.window, game.episode):
        read |= fields_read(node)
    for observable in game.observables:
        read.add((observable.entity_type.what, observable.entity_type.name, observable.field))
    marking = {phase.name for phase in seen_marks(game)}
    pruned = _pruned_game(game, read, marking)
    while True:
        found = set(read)
        for phase in (*beginning_phases(pruned), *pruned.schedule):
            found |= fields_read(phase)
        if found == read:
            return Relevant(pruned, frozenset(read))
        read = found
        pruned = _pruned_game(game, read, marking)


def _without_unseen(seen: set[str], node: ir.Node) -> ir.Node | tuple[()]:
    """Returns a node, but nothing for a `tally` of an event that agents don't see."""
    return () if isinstance(node, ir.Tally) and node.event not in seen else node


def _pruned_game(game: ir.Game, read: set[FieldName], marking: set[str]) -> ir.Game:
    turns = []
    for turn in game.schedule:
        if isinstance(turn, ir.Phase):
            turn = _pruned_phase(turn, read, marking)
        turns.append(turn)
    start = _pruned_phase(game.start, read, marking)
    starting = tuple(_pruned_phase(phase, read, marking) for phase in game.starting)
    return game.model_copy(update={"start": start, "starting": starting, "schedule": tuple(turns)})


def _pruned_phase(phase: ir.Phase, read: set[FieldName], marking: set[str]) -> ir.Phase:
    pruner = _Pruner(read, phase.name in marking)
    return phase.model_copy(update={"body": pruner.block(phase.body)})


def _names(read: ir.FieldRead) -> set[FieldName]:
    return {
        (read.held_by.what, name, read.name) for name in read.held_by.names or (read.held_by.name,)
    }


def fields_read(node: ir.Node) -> set[FieldName]:
    """Returns the fields that a part of the rules reads; what it only writes isn't read."""
    if isinstance(node, ir.FieldRead):
        inner = set() if node.owner is None else fields_read(node.owner)
        return inner | _names(node)
    if isinstance(node, ir.Set | ir.Add):
        field = written_field(node.target)
        parts = [node.value, *written_keys(node.target)]
        if field.owner is not None:
            parts.append(field.owner)
        return set().union(*map(fields_read, parts))
    return set().union(*map(fields_read, ir.children(node)))


def set_in(body: tuple[ir.Stmt, ...]) -> set[FieldName]:
    """Returns the fields that a block sets for sure, whatever the state."""
    return {
        name
        for statement in body
        if isinstance(statement, ir.Set) and isinstance(statement.target, ir.FieldRead)
        for name in _names(statement.target)
    }


class _Pruner:
    """Leaves statements out. read: the fields that matter; marks: whether marks are seen."""

    def __init__(self, read: set[FieldName], marks: bool) -> None:
        self.read = read
        self.marks = marks

    def block(self, body: tuple[ir.Stmt, ...]) -> tuple[ir.Stmt, ...]:
        kept: list[ir.Stmt] = []
        for statement in reversed(body):
            pruned = self._pruned(statement, kept)
            if pruned is not None:
                kept.insert(0, pruned)
        return tuple(kept)

    def _pruned(self, s: ir.Stmt, after: list[ir.Stmt]) -> ir.Stmt | None:
        """Returns a statement with what matters of it; None if nothing does."""
        match s:
            case ir.Let() | ir.Draw():
                nodes = (node for later in after for node in ir.walk(later))
                is_read = any(isinstance(n, ir.Local) and n.name == s.name for n in nodes)
                return s if is_read else None
            case ir.Mark():
                return s if self.marks else None
            case ir.Set() | ir.Add():
                return s if _names(written_field(s.target)) & self.read else None
            case (
                ir.Give()
                | ir.Tally()
                | ir.Send()
                | ir.Shift()
                | ir.Face()
                | ir.Remove()
                | ir.Move()
                | ir.End()
            ):
                return s
            case ir.Each() | ir.First() | ir.Match():
                body = self.block(s.body)
                return s.model_copy(update={"body": body}) if body else None
            case ir.Pick():
                body = self.block(s.body)
                otherwise = self.block(s.otherwise)
                changed = {"body": body, "otherwise": otherwise}
                return s.model_copy(update=changed) if body or otherwise else None
            case ir.When() | ir.Chance():
                return self._pruned_branches(s)
            case _:
                assert_never(s)

    def _pruned_branches(self, s: ir.When | ir.Chance) -> ir.Stmt | None:
        branches = [
            branch.model_copy(update={"body": self.block(branch.body)}) for branch in s.branches
        ]
        otherwise = self.block(s.otherwise)
        while branches and not otherwise and not branches[-1].body:
            branches.pop()
        if not branches:
            return None
        return s.model_copy(update={"branches": tuple(branches), "otherwise": otherwise})
