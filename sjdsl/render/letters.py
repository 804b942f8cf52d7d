"""Boards in characters.

There is one for each state of a cell and each type of mover. Agents are arrows; their numbers stand
beside the rows.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import prod

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import starts_of
from sjdsl.interpreter.board import Board
from sjdsl.interpreter.state import Cell, World
from sjdsl.render.moment import Snapshot, snapshot_of

ARROWS = "^>v<"
MAX_STATES = 12  # of one kind; if a kind has more states, only its first field is shown
SPARE = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
NONE_LEFT = "?"

State = tuple[str, ...]  # the enum value of each field that is shown


@dataclass(frozen=True)
class Letters:
    """The characters of a game.

    characters: kind and state -> the character of such a cell; shown: kind -> the fields of its
    states; movers: type of mover -> its character.
    """

    characters: Mapping[tuple[str, State], str]
    shown: Mapping[str, tuple[ir.VarField, ...]]
    movers: Mapping[str, str]

    def legend(self) -> list[str]:
        """Returns what each character stands for: `r soil: ripe`."""
        lines = []
        for (kind, state), character in self.characters.items():
            line = f"{character} {kind}"
            lines.append(f"{line}: {', '.join(state)}" if state else line)
        for mover, character in self.movers.items():
            lines.append(f"{character} {mover}")
        return lines

    def legend_line(self) -> str:
        """Returns the legend of boards with agents on them."""
        return "   ".join([*self.legend(), f"{ARROWS} agents"])

    def states(self, board: Board, snapshot: Snapshot) -> Iterator[tuple[Cell, str, int, State]]:
        """Yields each cell, its kind, its number among the cells of its kind, and its state."""
        for kind, cells in board.cells.items():
            for number, cell in enumerate(cells):
                state = []
                for field in self.shown[kind]:
                    value = snapshot.values[f"{kind}_{field.name}"][number]
                    state.append(field.type.words[int(value)])
                yield cell, kind, number, tuple(state)


def make_letters(game: ir.Game) -> Letters:
    """Returns the characters of a game: its glyphs, and letters for states that have no glyph.

    Such a letter is taken from an enum value that the kind's first glyph doesn't have.
    """
    characters: dict[tuple[str, State], str] = {}
    shown: dict[str, tuple[ir.VarField, ...]] = {}
    for kind in game.kinds:
        fields = tuple(f for f in kind.fields if f.type.kind == "word" and not f.type.indexed_by)
        num_states = prod(len(f.type.words) for f in fields)
        shown[kind.name] = fields if num_states <= MAX_STATES else fields[:1]
    movers = {mover.name: mover.glyph for mover in game.movers}
    for meaning in game.glyphs:
        starts = starts_of(game, meaning)
        state = tuple(str(starts[f.name]) for f in shown[meaning.kind])
        characters.setdefault((meaning.kind, state), meaning.glyph)
    for name, fields in shown.items():
        unknown = ("",) * len(fields)
        usual = next((state for kind, state in characters if kind == name), unknown)
        for state in product(*(f.type.words for f in fields)):
            if (name, state) not in characters:
                pairs = zip(state, usual, strict=True)
                differing = [word for word, usual_word in pairs if word != usual_word]
                used = {*characters.values(), *movers.values(), *ARROWS}
                characters[name, state] = _unused_character(differing, used)
    return Letters(characters, shown, movers)


def _unused_character(words: Sequence[str], used: Collection[str]) -> str:
    """Returns an unused letter: the first of a word, small or large, another of it, or any."""
    first_letters = [word[0] + word[0].upper() for word in words]
    letters = "".join((*first_letters, *words, SPARE))
    return next((c for c in letters if c.isalnum() and c not in used), NONE_LEFT)


def draw(letters: Letters, board: Board, world: World) -> list[str]:
    """Returns the map of a world of the interpreter, as `board_rows` does of a snapshot."""
    return board_rows(letters, board, snapshot_of(board.game, world, ()))


def board_rows(letters: Letters, board: Board, snapshot: Snapshot) -> list[str]:
    """Returns the rows of the map; beside each the numbers of its agents from left to right."""
    rows = [list(row) for row in board.game.rows]
    for cell, kind, _, state in letters.states(board, snapshot):
        rows[cell.row][cell.col] = letters.characters[kind, state]
    lines = with_figures(rows, snapshot, letters.movers, ARROWS)
    return [f"{line}  {' '.join(map(str, numbers))}".rstrip() for line, numbers in lines]


def with_figures(
    rows: list[list[str]], snapshot: Snapshot, movers: Mapping[str, str], arrows: str
) -> list[tuple[str, tuple[int, ...]]]:
    """Returns each row with agents and movers on it, and the numbers of its agents in order.

    Args:
      rows: the characters of the cells; overwritten.
      movers: type of mover -> its character.
      arrows: the characters of agents that face north, east, south, west.
    """
    agents: list[list[tuple[int, int]]] = [[] for _ in rows]  # of each row: column, number
    for name, number, row, col in snapshot.standing():
        if name == "agent":
            rows[row][col] = arrows[snapshot.heading[number]]
            agents[row].append((col, number))
        else:
            rows[row][col] = movers[name]
    lines = []
    for characters, agents_of_row in zip(rows, agents, strict=True):
        numbers = tuple(number for _, number in sorted(agents_of_row))
        lines.append(("".join(characters), numbers))
    return lines
