"""Symmetry of the rules of a step under renumbered agents or movers, decided by reading them.

A rule that reads a number breaks it. Everything but `agent.index`, a table by agent, and a number
for an argument of an action (`vote(3)`) refers to agents and cells, never to numbers. So a game
whose rules read none of these goes on alike when agents swap numbers.
"""

from collections.abc import Iterator

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ir.entity_types import AGENTS
from sjdsl.compiler.ir.free_variables import variables_around
from sjdsl.compiler.ir.queries import beginning_phases, body_type
from sjdsl.interpreter.evaluate import arguments_of
from sjdsl.properties.instances import GameFamily


def why_asymmetric(check: ir.Check, family: GameFamily) -> str:
    """Returns which line of a step tells agents, or movers, apart, and how; "" if none does.

    That is so for every number of agents that the file allows: a rule that names all of them by
    their numbers doesn't name all if there are more.
    """
    entity_type = _entity_type_of(check)
    forbid = _forbidden_by_number(family) if entity_type == AGENTS else None
    if forbid is None:
        return _why_asymmetric(entity_type, family.own)
    if family.number_varies and not family.number_is_a_size:
        return (
            f"line {forbid.span.line} names agents by their numbers, and the file allows several "
            "numbers of agents"
        )
    reasons = (_why_asymmetric(entity_type, game) for game in family.in_all_numbers())
    return next(filter(None, reasons), "")


def _forbidden_by_number(family: GameFamily) -> ast.Forbid | None:
    """Returns a `forbid` that names an agent by its number; None if none does.

    `forbid vote(0)` does, `forbid vote(x)`, where x is any of them, doesn't.
    """
    composition = family.composition
    constants = {*composition.constants, *composition.defines}
    declared = {action.name: action.arguments for action in family.own.agents.with_arguments}
    for forbid in composition.forbids.values():
        for chosen in forbid.actions:
            arguments = declared.get(chosen.name.text, ())
            # An action that is written without arguments stands for all of them.
            for tree, argument in zip(chosen.arguments or (), arguments, strict=False):
                is_variable = isinstance(tree, ast.Path) and tree.name.text not in constants
                if argument.type.kind == "agent" and not is_variable:
                    return forbid
    return None


def _why_asymmetric(entity_type: ir.EntityType, game: ir.Game) -> str:
    """Returns which line of a game tells agents or movers apart, and how; "" if none does."""
    for rule in _rules_of_a_step(game):
        for node in ir.walk(rule):
            reason = _reads_number(node, entity_type)
            if not reason and entity_type == AGENTS:
                reason = _names_agents(node, game)
            if reason:
                return f"line {_line(node, rule)} {reason}"
    return ""


def _rules_of_a_step(game: ir.Game) -> tuple[ir.Node, ...]:
    """Returns what happens in steps. In a game with trials, the phases with which a trial begins
    are part of the step that ends one."""
    starts = () if game.trials is None else beginning_phases(game)
    return (*game.schedule, *starts, game.agents, *game.kinds)


def why_symmetric(check: ir.Check, game: ir.Game) -> str:
    """Returns why a game is symmetric in which no rule of a step tells anything apart.

    And what that leaves out.
    """
    entity_type = _entity_type_of(check)
    whose = (
        "an agent's number" if entity_type == AGENTS else f"the number of a `{entity_type.name}`"
    )
    reason = f"no rule of a step reads {whose}"
    for phase in beginning_phases(game):
        for node in ir.walk(phase):
            if _reads_number(node, entity_type):
                does = f"`phase {phase.label}` does, in line {_line(node, phase)}"
                return f"{reason}; {does}, and is not part of this"
    return reason


def order_of_sending(check: ir.Check, game: ir.Game) -> tuple[list[ir.Send], list[ir.Send]]:
    """Returns the `send`s in which it matters that lower numbers are sent first.

    First those whose fitting cells differ from one agent (or mover) to another, then those for
    which cells may run out.
    """
    entity_type = _entity_type_of(check)
    choosy: list[ir.Send] = []
    crowded: list[ir.Send] = []
    for rule in _rules_of_a_step(game):
        for node in ir.walk(rule):
            if isinstance(node, ir.Send) and body_type(node.who) == entity_type:
                if variables_around(node.domain):
                    choosy.append(node)
                if node.stay:
                    crowded.append(node)
    return choosy, crowded


def _entity_type_of(check: ir.Check) -> ir.EntityType:
    """Returns the sort that `symmetric agents` or `symmetric deer` speaks of."""
    (what,) = check.words
    return AGENTS if what == "agents" else ir.EntityType("mover", (what,))


def _line(node: ir.Node, around: ir.Node) -> int:
    """Returns the line of a node, or of a rule around it if the node is written nowhere."""
    return (node.origin or around.span).line


def _reads_number(node: ir.Node, entity_type: ir.EntityType) -> str:
    """Returns how a node reads the number of an agent or mover; "" if it doesn't."""
    match node:
        case ir.Attribute(name="index", owner=owner) if body_type(owner) == entity_type:
            return f"reads `{'agent' if entity_type == AGENTS else entity_type.name}.index`"
        case ir.ParamRef(name=name) if entity_type == AGENTS and any(
            index_set.kind == "agent" for index_set in node.type.indexed_by
        ):
            return f"reads `{name}`, a table by agent"
        case _:
            return ""


def _names_agents(node: ir.Node, game: ir.Game) -> str:
    """Returns how a node names an agent by its number; "" if it names none.

    `chose vote(0)` and `forbid vote(0)` do.
    """
    match node:
        case ir.Given(type=ir.Type(kind="agent"), value=ir.Number(value=number)):
            return f"names agent {number:g} by its number"
        case ir.Forbid(actions=actions):
            forbidden = set(actions)
            for group in _alike_but_for_agents(game):
                if group & forbidden and not group <= forbidden:
                    return "forbids an action on some agents, which it names by their numbers"
            return ""
        case _:
            return ""


def _alike_but_for_agents(game: ir.Game) -> Iterator[set[int]]:
    """Yields the actions that differ only in agents, together: `vote(0)`, `vote(1)`, …"""
    for action in game.agents.with_arguments:
        groups: dict[tuple[object, ...], set[int]] = {}
        for number in action.numbers:
            values = arguments_of(action, number)
            assert values is not None
            others = tuple(
                value
                for value, argument in zip(values, action.arguments, strict=True)
                if argument.type.kind != "agent"
            )
            groups.setdefault(others, set()).add(number)
        yield from groups.values()
