"""How a game looks on the screen: a letter and a colour for each state of a cell, a colour for each agent and each beam."""

from collections.abc import Mapping
from dataclasses import dataclass

from sjdsl.compiler import ir
from sjdsl.interpreter.board import board_of
from sjdsl.render.colours import Colour, agent_colour, kind_colours, mark_colours, word_colours
from sjdsl.screen.palette import faint_on, ink_on, told_apart
from sjdsl.trace.picture import Looks, State, make_looks

OWN: Colour = (255, 0, 255)  # of the agent that is steered, and of nothing else
NUMBERS = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"


@dataclass(frozen=True)
class ScreenLooks:
    """letters: as `sjdsl trace` has them. tiles: (kind, its shown fields) -> colour. marks: name of a phase -> its label and colour.

    agents: a colour for each. owners, amounts: by kind, the field whose agent, or whose number, stands beside the letter.
    """

    letters: Looks
    tiles: Mapping[tuple[str, State], tuple[Colour, Colour]]
    marks: Mapping[str, tuple[str, Colour]]
    agents: tuple[Colour, ...]
    owners: Mapping[str, str]
    amounts: Mapping[str, str]


def make_screen_looks(game: ir.Game) -> ScreenLooks:
    """Returns how a game looks; no two colours of the map are alike in a terminal of 256."""
    letters = make_looks(game)
    on_map = set(board_of(game).kind_of.values())
    states = [key for key in letters.characters if key[0] in on_map]
    phases = [p for p in (game.start, *game.schedule) if isinstance(p, ir.Phase) and p.marks]
    tiles = told_apart([_wanted(game, *state) for state in states], [OWN])
    marks = told_apart(mark_colours(tuple(p.label for p in phases)), [OWN, *tiles])
    agents = told_apart([agent_colour(number) for number in range(game.agents.number)], [OWN, *tiles, *marks])
    return ScreenLooks(
        letters=letters,
        tiles={state: (tile, ink_on(tile) if _inks(game, *state) else faint_on(tile)) for state, tile in zip(states, tiles, strict=True)},
        marks={p.name: (p.label, colour) for p, colour in zip(phases, marks, strict=True)},
        agents=tuple(agents),
        owners={kind.name: f.name for kind in game.kinds for f in reversed(kind.fields) if f.type.kind == "agent" and not f.type.by},
        amounts={kind.name: f.name for kind in game.kinds for f in reversed(kind.fields) if _is_amount(f)},
    )


def letter_of(agent: int) -> str:
    """Returns the one letter that stands for an agent's number: 0 to 9, a for 10, b for 11 and so on."""
    return NUMBERS[agent] if agent < len(NUMBERS) else "+"


def _wanted(game: ir.Game, kind: str, state: State) -> Colour:
    """Returns the colour of a state of a cell: that of its words where they say more than its kind does."""
    inks = _inks(game, kind, state)
    if not inks:
        return kind_colours(game)[kind]
    red, green, blue = (round(sum(ink[channel] for ink in inks) / len(inks)) for channel in range(3))
    return red, green, blue


def _inks(game: ir.Game, kind: str, state: State) -> list[Colour]:
    """Returns the colours of the words that make a state more than plain: all but the first word of each field."""
    declared = {f.name: f.type.words for k in game.kinds if k.name == kind for f in k.fields}
    return [word_colours(declared[name])[declared[name].index(word)] for name, word in state if declared[name].index(word) > 0]


def _is_amount(field: ir.VarField) -> bool:
    return field.type.kind == "int" and not field.type.by and not field.timer
