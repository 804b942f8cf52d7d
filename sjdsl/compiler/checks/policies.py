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
    are_one_field,
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
    closed: list[tuple[str, ir.Expr]] = []
    for kind in game.kinds:
        if num_cells(game, (kind.name,)):
            for condition in _conditions(kind, are_seen=False):
                if _lasts(condition, game):
                    closed.append((kind.name, condition))
    for walk in _walks(game):
        if isinstance(walk, ir.Go):
            _check_goal(walk.domain, game, sources, problems)
        named = walk.domain.var.entity_type.names
        if walk.avoided is not None:
            named += walk.avoided.var.entity_type.names
        for name, condition in closed:
            if name not in named:
                when = _written(condition, sources)
                avoided = f"{name} where {when}"
                if _reads_heading(condition):  # then each turn of the agent closes other cells
                    avoided = name
                problems.add(errors.BlindPath(walk.span, kind=name, when=when, avoided=avoided))


def _reads_heading(condition: ir.Expr) -> bool:
    attributes = [node for node in ir.walk(condition) if isinstance(node, ir.Attribute)]
    return any(attribute.name == "heading" for attribute in attributes)


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
        of_goal = renamed(condition, {kind.name: goal.var.name})
        if all(is_known(part, known) for part in conjuncts(of_goal)):
            return f" when {_written(condition, sources)}"
    return None


def _conditions(kind: ir.Kind, are_seen: bool = True) -> list[ir.Expr]:
    """Returns the conditions under which cells of a kind block agents.

    are_seen: with those that paths take into account.
    """
    conditions = []
    for block in kind.blocks:
        if block.what == "agents" and block.condition is not None:
            if are_seen or not closes_paths(block):
                conditions.append(block.condition)
    return conditions


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
    for read in ir.walk(condition):
        if isinstance(read, ir.FieldRead):
            is_written = any(are_one_field(field, read) for field in written)
            if is_written or declared_field(game, read).timer:
                return False
    return True


def _written(condition: ir.Expr, sources: Mapping[str, Source]) -> str:
    """Returns a condition as its author wrote it."""
    span = condition.span
    return " ".join(sources[span.file].text[span.start : span.end].split())
