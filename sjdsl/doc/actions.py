"""The table of actions: numbers, names, and what each does."""

from sjdsl.compiler import ir
from sjdsl.doc.wording import code, joined, number

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


def action_rows(game: ir.Game) -> list[tuple[str, str, str]]:
    """Returns the numbers, the name and the meaning of every action; an action with arguments has one row."""
    first = {action.first: action for action in game.agents.with_arguments}
    inside = {number for action in game.agents.with_arguments for number in action.numbers}
    found = []
    for at, name in enumerate(game.agents.actions):
        if at in first:
            action, last = first[at], first[at].numbers[-1]
            found.append(
                (
                    str(at) if last == at else f"{at} to {last}",
                    code(declared(action)),
                    _meaning(action.name, action.name, game),
                )
            )
        elif at not in inside:
            found.append((str(at), code(name), _meaning(name, at, game)))
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


def _meaning(name: str, action: int | str, game: ir.Game) -> str:
    """Returns what an action does, by its number, or by its name if it takes arguments: the move it is, and the phases that ask for it."""
    said = []
    if name in RELATIVE and any(
        isinstance(node, ir.Move) and node.course is None for node in ir.walk(game)
    ):
        said.append((RELATIVE if game.agents.relative else COMPASS)[name])
    phases = (turn for turn in game.schedule if isinstance(turn, ir.Phase))
    asks = (
        p
        for p in phases
        if any(isinstance(n, ir.Chose | ir.ChoseWith) and n.action == action for n in ir.walk(p))
    )
    asking = dict.fromkeys(code(phase.label.partition("(")[0]) for phase in asks)
    if asking:
        said.append(f"what {joined(asking)} {'says' if len(asking) == 1 else 'say'}")
    return "; ".join(said) or "nothing"
