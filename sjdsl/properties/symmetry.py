"""Symmetry of the rules of a step under renumbered agents or movers, decided by reading them: a rule that reads a number breaks it.

Everything but `agent.index`, a table by agent, and a number for an argument of an action (`vote(3)`) refers to agents and cells, never to
numbers. So a game whose rules read none of these goes on alike when agents swap numbers.
"""

from collections.abc import Iterator

from sjdsl.compiler import ast, ir
from sjdsl.compiler.ir.free_variables import variables_around
from sjdsl.compiler.ir.queries import body_sort
from sjdsl.compiler.ir.sorts import AGENTS
from sjdsl.interpreter.evaluate import arguments_of
from sjdsl.properties.instances import GameFamily


def why_asymmetric(check: ir.Check, family: GameFamily) -> str:
    """Returns which line of a step tells agents (or movers of a sort) apart, and how; nothing if none does.

    With every number of agents that the file allows: a rule that names all by their numbers names only some of more agents.
    """
    sort = _sort_of(check)
    numbered = _forbidden_by_number(family) if sort == AGENTS else None
    if numbered is None:
        return _why_asymmetric(sort, family.own)
    if family.number_varies and not family.number_is_a_size:
        return f"line {numbered.span.line} names agents by their numbers, and the file allows several numbers of agents"
    return next(filter(None, (_why_asymmetric(sort, game) for game in family.in_all_numbers())), "")


def _forbidden_by_number(family: GameFamily) -> ast.Forbid | None:
    """Returns a `forbid` that names agents by numbers, as `forbid vote(0)` does; not `forbid vote(x)`, where x is any of them."""
    composition = family.composition
    declared = {action.name: action.arguments for action in family.own.agents.with_arguments}
    for forbid in composition.forbids.values():
        for chosen in forbid.actions:
            for tree, argument in zip(
                chosen.arguments or (), declared.get(chosen.name.text, ()), strict=False
            ):
                is_name = isinstance(tree, ast.Path) and tree.name.text not in {
                    *composition.constants,
                    *composition.defines,
                }
                if argument.type.kind == "agent" and not is_name:
                    return forbid
    return None


def _why_asymmetric(sort: ir.Sort, game: ir.Game) -> str:
    for rule in (*game.schedule, game.agents, *game.kinds):
        for node in ir.walk(rule):
            if told := _reads_number(node, sort) or (
                _names_agents(node, game) if sort == AGENTS else ""
            ):
                return f"line {_line(node, rule)} {told}"
    return ""


def why_symmetric(check: ir.Check, game: ir.Game) -> str:
    """Returns why a game is symmetric in which no rule of a step tells anything apart, and what that leaves out."""
    sort = _sort_of(check)
    whose = "an agent's number" if sort == AGENTS else f"the number of a `{sort.name}`"
    told = [node for node in ir.walk(game.start) if _reads_number(node, sort)]
    start = (
        f"; `phase start` does, in line {_line(told[0], game.start)}, and is not part of this"
        if told
        else ""
    )
    return f"no rule of a step reads {whose}{start}"


def order_of_sending(check: ir.Check, game: ir.Game) -> tuple[list[ir.Send], list[ir.Send]]:
    """Returns where it matters that lower numbers are sent first: where the cells that fit differ from one to another, and if cells run out."""
    nodes = (node for rule in (*game.schedule, game.agents, *game.kinds) for node in ir.walk(rule))
    sends = [
        node
        for node in nodes
        if isinstance(node, ir.Send) and body_sort(node.who) == _sort_of(check)
    ]
    return [send for send in sends if variables_around(send.domain)], [
        send for send in sends if send.stay
    ]


def _sort_of(check: ir.Check) -> ir.Sort:
    """Returns the sort that `symmetric agents` or `symmetric deer` speaks of."""
    (what,) = check.words
    return AGENTS if what == "agents" else ir.Sort("mover", (what,))


def _line(node: ir.Node, around: ir.Node) -> int:
    return (node.origin or around.span).line


def _reads_number(node: ir.Node, sort: ir.Sort) -> str:
    """Returns how a value depends on the number of an agent, or of a mover of a sort; nothing if it does not."""
    match node:
        case ir.Attribute(name="index", owner=owner) if body_sort(owner) == sort:
            return f"reads `{'agent' if sort == AGENTS else sort.name}.index`"
        case ir.ParamRef(name=name) if sort == AGENTS and any(
            level.sort == "agent" for level in node.type.by
        ):
            return f"reads `{name}`, a table by agent"
        case _:
            return ""


def _names_agents(node: ir.Node, game: ir.Game) -> str:
    """Returns how a node names an agent by a number that is written, as `chose vote(0)` and `forbid vote(0)` do; nothing if it names none."""
    match node:
        case ir.Given(type=ir.Type(kind="agent"), value=ir.Number(value=number)):
            return f"names agent {number:g} by its number"
        case ir.Forbid() if any(
            0 < len(group & set(node.actions)) < len(group) for group in _alike_but_for_agents(game)
        ):
            return "forbids an action on some agents, which it names by their numbers"
        case _:
            return ""


def _alike_but_for_agents(game: ir.Game) -> Iterator[set[int]]:
    """Yields the numbers of actions that differ only in which agents their arguments are: `vote(0)`, `vote(1)`, …"""
    for action in game.agents.with_arguments:
        groups: dict[tuple[object, ...], set[int]] = {}
        for number in action.numbers:
            values = arguments_of(action, number)
            assert values is not None
            pairs = zip(values, action.arguments, strict=True)
            rest = tuple(value for value, argument in pairs if argument.type.kind != "agent")
            groups.setdefault((action.name, *rest), set()).add(number)
        yield from groups.values()
