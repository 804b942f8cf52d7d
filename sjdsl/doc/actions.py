"""The English of actions: their table, and when they are forbidden."""

from collections.abc import Iterable

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import action_named
from sjdsl.doc.phrases import condition
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import Line, code, codes, joined, number

RELATIVE = {
    "turn_left": "turns a quarter to the left",
    "turn_right": "turns a quarter to the right",
    "step_left": "steps to the cell on its left",
    "step_right": "steps to the cell on its right",
    "forward": "steps to the cell in front of it",
    "backward": "steps to the cell behind it",
}
COMPASS = RELATIVE | {
    "step_left": "steps one cell west",
    "step_right": "steps one cell east",
    "forward": "steps one cell north",
    "backward": "steps one cell south",
}
EVERY = "every action"


def action_rows(v: Vocabulary) -> list[tuple[str, str, str]]:
    """Returns the numbers, the name and the meaning of every action; an action with arguments has one row."""
    agents = v.game.agents
    first = {action.first: action for action in agents.with_arguments}
    inside = {number for action in agents.with_arguments for number in action.numbers}
    found = []
    for at, name in enumerate(agents.actions):
        if at in first:
            action, last = first[at], first[at].numbers[-1]
            found.append((str(at) if last == at else f"{at} to {last}", code(declared(action)), _meaning_with(action, v)))
        elif at not in inside:
            found.append((str(at), code(name), _meaning(at, name, v)))
    return found


def declared(action: ir.ActionWithArguments) -> str:
    """Returns an action with its arguments as it is declared: `offer(apples : 0 .. 2, pears : 0 .. 2)`."""
    return f"{action.name}({', '.join(map(_argument, action.arguments))})"


def _argument(argument: ir.ActionArgument) -> str:
    match argument.type.kind:
        case "word":
            values = f"{{ {', '.join(argument.type.words)} }}"
        case "int":
            values = f"{number(argument.type.low)} .. {number(argument.type.high)}"
        case _:
            values = "agent"
    return f"{argument.name} : {values}" if argument.name else values


def action_names(agents: ir.Agents) -> list[str]:
    """Returns the names of the actions; an action with arguments stands there once, as it is declared."""
    inside = {number for action in agents.with_arguments for number in action.numbers}
    first = {action.first: declared(action) for action in agents.with_arguments}
    return [first.get(i, name) for i, name in enumerate(agents.actions) if i in first or i not in inside]


def _meaning(action: int, name: str, v: Vocabulary) -> str:
    said = []
    if name == "stay":
        said.append("nothing")
    elif name in RELATIVE:
        moves = RELATIVE if v.game.agents.relative else COMPASS
        said.append(
            moves[name]
            if any(isinstance(node, ir.Move) and node.course is None for node in v.nodes)
            else "nothing by itself: no phase lets agents move"
        )
    asking = [label for label, nodes in v.phases.items() if any(isinstance(n, ir.Chose) and n.action == action for n in nodes)]
    if asking:
        said.append(f"what phase {codes(asking)} says")
    return "; ".join(said) or "nothing"


def _meaning_with(action: ir.ActionWithArguments, v: Vocabulary) -> str:
    asking = [label for label, nodes in v.phases.items() if any(isinstance(n, ir.ChoseWith) and n.action == action.name for n in nodes)]
    said = f"what phase {codes(asking)} says" if asking else "nothing"
    return f"{said}; one action for each choice of {'an argument' if len(action.arguments) == 1 else 'arguments'}"


def forbidden(v: Vocabulary) -> list[Line]:
    """Returns which actions count as `stay`, and when."""
    stay = v.game.agents.actions.index("stay")
    others = set(range(len(v.game.agents.actions))) - {stay}
    found = []
    for forbid in v.game.agents.forbids:
        names = _named(forbid, v) if forbid.names else chosen_names((a for a in forbid.actions if a != stay), v)
        what = EVERY if others <= set(forbid.actions) and len(others) > 1 and not forbid.names else joined(names)
        counts = "count" if len(names) > 1 and what != EVERY else "counts"
        found.append(Line(f"{what} of an agent {counts} as {code('stay')} while {condition(forbid.condition, v)}"))
    return found


def _named(forbid: ir.Forbid, v: Vocabulary) -> list[str]:
    """Returns the action of a `forbid` with the names that it gives its arguments; a fixed argument shows its value."""
    action, values = action_named(v.game, forbid.action), list[str]()
    names = [v.game.agents.actions[number] for number in forbid.actions]  # each as `offer(1, 2)`
    texts = [name[name.index("(") + 1 : -1].split(", ") for name in names]
    for place, name in enumerate(forbid.names):
        seen = {text[place] for text in texts}
        values.append(name or (seen.pop() if len(seen) == 1 else "any"))
    return [code(f"{action.name}({', '.join(values)})")]


def chosen_names(actions: Iterable[int], v: Vocabulary) -> list[str]:
    """Returns actions by name; all of an action with arguments by its name alone."""
    left, found = list(actions), list[str]()
    for action in v.game.agents.with_arguments:
        if set(action.numbers) <= set(left):
            at = left.index(action.first)
            left = [a for a in left if a not in action.numbers]
            left.insert(at, -1 - v.game.agents.with_arguments.index(action))
    for number_ in left:
        found.append(v.action(number_) if number_ >= 0 else code(v.game.agents.with_arguments[-1 - number_].name))
    return found
