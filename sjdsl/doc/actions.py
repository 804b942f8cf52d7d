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
    """Returns the number, name and meaning of every action; one with arguments has one row."""
    by_first_number = {action.first: action for action in game.agents.with_arguments}
    with_arguments = {number for action in game.agents.with_arguments for number in action.numbers}
    rows = []
    for index, name in enumerate(game.agents.actions):
        if index in by_first_number:
            action = by_first_number[index]
            last = action.numbers[-1]
            numbers = str(index) if last == index else f"{index} to {last}"
            meaning = _meaning(action.name, action.name, game)
            rows.append((numbers, code(declared(action)), meaning))
        elif index not in with_arguments:
            rows.append((str(index), code(name), _meaning(name, index, game)))
    return rows


def declared(action: ir.ActionWithArguments) -> str:
    """Returns an action as it is declared: `offer(apples : 0 .. 2, pears : 0 .. 2)`."""
    return f"{action.name}({', '.join(map(_argument, action.arguments))})"


def _argument(argument: ir.ActionArgument) -> str:
    """Returns an argument of an action with its values: `target : agent`."""
    match argument.type.kind:
        case "word":
            values = f"{{ {', '.join(argument.type.words)} }}"
        case "int":
            values = f"{number(argument.type.low)} .. {number(argument.type.high)}"
        case _:
            values = "agent"
    return f"{argument.name} : {values}" if argument.name else values


def _meaning(name: str, action: int | str, game: ir.Game) -> str:
    """Returns what an action does: the move that it is, and the phases that ask for it.

    Args:
      action: its number, or its name if it has arguments.
    """
    meanings = []
    if name in RELATIVE and _has_built_in_moves(game):
        meanings.append((RELATIVE if game.agents.relative else COMPASS)[name])
    phases: dict[str, None] = {}
    for phase in game.schedule:
        if isinstance(phase, ir.Phase) and _asks_for(action, phase):
            phases[code(phase.label.partition("(")[0])] = None
    if phases:
        meanings.append(f"what {joined(phases)} {'says' if len(phases) == 1 else 'say'}")
    return "; ".join(meanings) or "nothing"


def _has_built_in_moves(game: ir.Game) -> bool:
    return any(isinstance(node, ir.Move) and node.course is None for node in ir.walk(game))


def _asks_for(action: int | str, phase: ir.Phase) -> bool:
    nodes = ir.walk(phase)
    return any(isinstance(n, ir.Chose | ir.ChoseWith) and n.action == action for n in nodes)
