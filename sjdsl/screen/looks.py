"""The appearance of a game on the screen: a letter and a colour for each state of a cell, a colour for agents, movers and beams."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import kind_named, marking_phases
from sjdsl.interpreter.board import board_of
from sjdsl.render.colours import Colour, agent_colour, mark_colours
from sjdsl.render.drawings import cell_keys, draw_cell, main_colour
from sjdsl.render.look import KindLook, herd_looks, kind_looks
from sjdsl.screen.palette import faint_on, ink_on, told_apart
from sjdsl.trace.picture import Looks, State, make_looks

OWN: Colour = (255, 0, 255)  # of the agent that is steered, and of nothing else
NUMBERS = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"


@dataclass(frozen=True)
class ScreenLooks:
    """letters: as `sjdsl trace` has them. tiles: (kind, its shown fields) -> colour. marks: name of a phase -> its label and colour.

    agents: a colour for each; movers: one for each sort. owners, amounts: by kind, the field whose agent, or whose number, stands beside the letter.
    """

    letters: Looks
    tiles: Mapping[tuple[str, State], tuple[Colour, Colour]]
    marks: Mapping[str, tuple[str, Colour]]
    agents: tuple[Colour, ...]
    movers: Mapping[str, Colour]
    owners: Mapping[str, str]
    amounts: Mapping[str, str]


def make_screen_looks(game: ir.Game) -> ScreenLooks:
    """Returns how a game looks; no two colours of the map are alike in a terminal of 256."""
    letters = make_looks(game)
    on_map = set(board_of(game).kind_of.values())
    states = [key for key in letters.characters if key[0] in on_map]
    phases = marking_phases(game)
    kinds = {kind.name: kind for kind in kind_looks(game)}
    drawn = [_drawn(game, kinds, *state) for state in states]
    tiles = told_apart([colour for colour, _ in drawn], [OWN])
    marks = told_apart(mark_colours(tuple(p.label for p in phases)), [OWN, *tiles])
    agents = told_apart([agent_colour(number) for number in range(game.agents.number)], [OWN, *tiles, *marks])
    herds = list(herd_looks(game))
    movers = told_apart([herd.colour for herd in herds], [OWN, *tiles, *marks, *agents])
    return ScreenLooks(
        letters=letters,
        tiles={
            state: (tile, ink_on(tile) if stands else faint_on(tile)) for state, tile, (_, stands) in zip(states, tiles, drawn, strict=True)
        },
        marks={p.name: (p.label, colour) for p, colour in zip(phases, marks, strict=True)},
        agents=tuple(agents),
        movers={herd.name: colour for herd, colour in zip(herds, movers, strict=True)},
        owners={kind.name: f.name for kind in game.kinds for f in reversed(kind.fields) if f.type.kind == "agent" and not f.type.by},
        amounts={kind.name: f.name for kind in game.kinds for f in reversed(kind.fields) if _is_amount(f)},
    )


def letter_of(agent: int) -> str:
    """Returns the one letter that stands for an agent's number: 0 to 9, a for 10, b for 11 and so on."""
    return NUMBERS[agent] if agent < len(NUMBERS) else "+"


def _drawn(game: ir.Game, kinds: Mapping[str, KindLook], kind: str, state: State) -> tuple[Colour, bool]:
    """Returns the colour that a picture would show most of in a state of a cell, and whether anything stands there."""
    words = dict(state)
    values = {f"{kind}_{f.name}": _one(f, words.get(f.name, f.start)) for f in kind_named(game, kind).fields}
    look = replace(kinds[kind], rows=np.zeros(1, int), cols=np.zeros(1, int))
    (key,), _ = cell_keys(look, values)
    return main_colour(draw_cell(look, key))


def _one(field: ir.VarField, value: object) -> np.ndarray:
    """Returns a value as the state of one cell holds it."""
    if field.type.kind == "agents":
        return np.zeros(1, np.uint32)
    if field.type.kind == "word":
        number: object = field.type.words.index(str(value))
    else:
        number = (-1 if field.type.kind == "agent" else 0) if value is None else value
    return np.full((1, *(len(words) for words in field.type.by)), number)


def _is_amount(field: ir.VarField) -> bool:
    return field.type.kind == "int" and not field.type.by and not field.timer
