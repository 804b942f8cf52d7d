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
    meanings = built_in_moves(name, game)
    asking = phases_asking_for(action, game)
    phases = dict.fromkeys(code(phase.label.partition("(")[0]) for phase in asking)
    if phases:
        meanings.append(f"what {joined(phases)} {'says' if len(phases) == 1 else 'say'}")
    return "; ".join(meanings) or "nothing"


def built_in_moves(name: str, game: ir.Game) -> list[str]:
    """Returns the turn or step that an action is; nothing if it is none."""
    if name not in RELATIVE or not has_built_in_moves(game):
        return []
    return [(RELATIVE if game.agents.relative else COMPASS)[name]]


def has_built_in_moves(game: ir.Game) -> bool:
    """Returns whether agents turn and step as they choose."""
    return any(
        isinstance(node, ir.Move) and node.course is None
        for turn in game.schedule
        for node in ir.walk(turn)
    )


def phases_asking_for(action: int | str, game: ir.Game) -> list[ir.Phase]:
    """Returns the phases of a step whose rules ask who chose an action.

    Args:
      action: its number, or its name if it has arguments.
    """
    return [
        turn
        for turn in game.schedule
        if isinstance(turn, ir.Phase)
        and any(
            isinstance(node, ir.Chose | ir.ChoseWith) and node.action == action
            for node in ir.walk(turn)
        )
    ]
