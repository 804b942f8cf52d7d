"""Parts of evaluation that need no instance: free names, arguments of actions, places of entries, arms, classes of matrix games."""

from collections.abc import Iterable
from itertools import islice, product
from typing import Literal, assert_never

from sjdsl.compiler import ir
from sjdsl.interpreter.state import Value


def binds_all(e: ir.Expr) -> bool:
    """Returns whether an expression binds every variable that it names, and so has one value in all instances."""
    return not _free_names(e)


def _free_names(node: ir.Node) -> set[str]:
    """Returns the variables of a node that it does not bind itself; a domain may bind a name that means something else around it."""
    if isinstance(node, (ir.Member, ir.Local)):
        return {node.name}
    if not isinstance(node, (ir.Count, ir.Sum, ir.Extreme)):
        return set().union(*map(_free_names, ir.children(node)))
    domain, value = node.domain, getattr(node, "value", None)
    inside = set().union(*(_free_names(part) for part in (domain.where, value) if part is not None))
    outside = [part for part in (domain.restriction, *ir.children(node)) if part is not None and part is not domain and part is not value]
    bound = {member.name for member in (domain.var, domain.on) if member is not None}
    return (inside - bound).union(*map(_free_names, outside))


def arguments_of(action: ir.ActionWithArguments, number: int) -> tuple[Value, ...] | None:
    """Returns the arguments of an action with this number; None if it is another action's."""
    if number not in action.numbers:
        return None
    values: list[Iterable[Value]] = []
    for argument in action.arguments:
        if argument.type.kind == "word":
            values.append(argument.type.words)
        else:
            low = int(argument.type.low) if argument.type.kind == "int" else 0
            values.append(range(low, low + argument.count))
    return next(islice(product(*values), number - action.first, None))


def agents_in(value: Value) -> Iterable[int]:
    """Returns the agents of a set, the one agent, or none."""
    if isinstance(value, frozenset):
        return value
    return frozenset() if value is None else frozenset({value})


def entry_place(level: ir.Level, key: Value) -> int:
    """Returns the place of the entry that a key names: a word, a number of the range, or an agent."""
    place = level.place_of(key)
    assert 0 <= place < len(level), f"no entry for {key} in {level}"
    return place


def applies(arm: ir.Arm, subject: int | str) -> bool:
    """Returns whether an arm of a `case` is for this word or number."""
    if isinstance(subject, str):
        return subject in arm.words
    return (arm.low is None or arm.low <= subject) and (arm.high is None or subject <= arm.high)


def is_of_class(name: Literal["prisoners_dilemma", "stag_hunt", "chicken"], table: tuple[tuple[Value, Value], tuple[Value, Value]]) -> bool:
    """Returns whether a table [own word][other's word], cooperation first, is such a game.

    Source: Macy and Flache, "Learning dynamics in social dilemmas", PNAS 2002; a chicken game by its order alone.
    """
    (reward, sucker), (temptation, punishment) = table
    match name:
        case "prisoners_dilemma":
            return bool(temptation > reward > punishment > sucker and 2 * reward > temptation + sucker)
        case "stag_hunt":
            return bool(reward > temptation >= punishment > sucker)
        case "chicken":
            return bool(temptation > reward > sucker > punishment)
        case _:
            assert_never(name)
