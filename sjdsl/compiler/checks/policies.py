"""Warns of rules of policies that cannot get anywhere.

Paths lead around what always blocks agents, and ignore what blocks them sometimes.
"""

from collections.abc import Iterator, Mapping

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.free_variables import free_variables, renamed
from sjdsl.compiler.ir.implications import conjuncts, facts, is_known
from sjdsl.compiler.ir.queries import (
    blocks_always,
    closes_paths,
    contains,
    declared_field,
    num_cells,
    written_field,
)

Walk = ir.Go | ir.Aim


def check_policies(game: ir.Game, sources: Mapping[str, Source], problems: Problems) -> None:
    """Warns of each `seek` and `aim` that cannot work, in policies and in checks."""
    there = [kind for kind in game.kinds if num_cells(game, (kind.name,))]
    closed = [
        (kind.name, condition)
        for kind in there
        for condition in _conditions(kind, are_seen=False)
        if _lasts(condition, game)
    ]
    for walk in _walks(game):
        if isinstance(walk, ir.Go):
            _check_goal(walk.domain, game, sources, problems)
        named = [d.var.entity_type.names for d in (walk.domain, walk.avoided) if d is not None]
        for kind, condition in closed:
            if not any(kind in names for names in named):
                when = _written(condition, sources)
                turns = any(
                    isinstance(node, ir.Attribute) and node.name == "heading"
                    for node in ir.walk(condition)
                )
                avoided = (
                    kind if turns else f"{kind} where {when}"
                )  # after each turn other cells block by heading
                problems.add(errors.BlindPath(walk.span, kind=kind, when=when, avoided=avoided))


def _walks(game: ir.Game) -> Iterator[Walk]:
    """Yields the rules by which policies of the file, and those of checks, walk somewhere."""
    for policy in game.policies:
        yield from (rule for rule in policy.rules if isinstance(rule, Walk))
    for check in game.checks:
        for played in check.policies:
            if played.domain is not None:
                yield ir.Go(domain=played.domain, origin=played.origin)


def _check_goal(
    goal: ir.Domain, game: ir.Game, sources: Mapping[str, Source], problems: Problems
) -> None:
    """Warns of a goal that agents cannot reach, or have reached wherever they are."""
    if (
        goal.var.entity_type == AGENTS
        and goal.on is None
        and goal.restriction is None
        and goal.where is None
    ):
        problems.add(errors.SeeksItself(goal.span, name=goal.var.name))
    elif goal.var.entity_type.what == "cell":
        kinds = [kind for kind in game.kinds if kind.name in goal.var.kinds]
        reasons = [_reason(kind, goal, sources) for kind in kinds]
        if None not in reasons:
            problems.add(
                errors.SoughtBlocks(
                    goal.span, kind=" and ".join(goal.var.kinds), when=reasons[0] or ""
                )
            )


def _reason(kind: ir.Kind, goal: ir.Domain, sources: Mapping[str, Source]) -> str | None:
    """Returns when the cells of a kind that are sought block agents.

    It is empty if they always do, and None if agents may enter them.
    """
    if blocks_always(kind):
        return ""
    known = () if goal.where is None else facts(goal.where)
    for condition in _conditions(kind):
        if all(
            is_known(part, known)
            for part in conjuncts(renamed(condition, {kind.name: goal.var.name}))
        ):
            return f" when {_written(condition, sources)}"
    return None


def _conditions(kind: ir.Kind, are_seen: bool = True) -> list[ir.Expr]:
    """Returns the conditions under which cells of a kind block agents.

    are_seen: with those that paths take into account.
    """
    return [
        block.condition
        for block in kind.blocks
        if block.what == "agents"
        and block.condition is not None
        and (are_seen or not closes_paths(block))
    ]


def _lasts(condition: ir.Expr, game: ir.Game) -> bool:
    """Returns whether a condition depends on the agent, and stays as it is while the agent waits.

    No rule changes what it reads.
    """
    if all(variable.name != "agent" for variable in free_variables(condition)):
        return False
    if contains(condition, ir.Step, ir.Count, ir.Sum, ir.Extreme, ir.Unoccupied):
        return False
    nodes = [node for turn in game.schedule for node in ir.walk(turn)]
    written = [written_field(node.target) for node in nodes if isinstance(node, ir.Set | ir.Add)]
    for read in (node for node in ir.walk(condition) if isinstance(node, ir.FieldRead)):
        changes = any(
            field.name == read.name and field.held_by.overlaps(read.held_by) for field in written
        )
        if changes or declared_field(game, read).timer:
            return False
    return True


def _written(condition: ir.Expr, sources: Mapping[str, Source]) -> str:
    """Returns a condition as its author wrote it."""
    span = condition.span
    return " ".join(sources[span.file].text[span.start : span.end].split())
