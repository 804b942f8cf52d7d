"""Boards in characters: one for each state of a cell and each sort of movers, arrows for agents, their numbers beside the rows."""

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
STATES = 12  # of one kind that get a character of their own; of a kind with more only its first field is shown
SPARE = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
NONE_LEFT = "?"

State = tuple[str, ...]  # the word of each field that is shown


@dataclass(frozen=True)
class Letters:
    """characters: kind and words of its shown fields -> the character of such a cell; shown: kind -> these fields. movers: sort -> its character."""

    characters: Mapping[tuple[str, State], str]
    shown: Mapping[str, tuple[ir.VarField, ...]]
    movers: Mapping[str, str]

    def legend(self) -> list[str]:
        """Returns what each character stands for: `r soil: ripe`."""
        cells = [
            f"{sign} {kind}: {', '.join(state)}" if state else f"{sign} {kind}"
            for (kind, state), sign in self.characters.items()
        ]
        return [*cells, *(f"{character} {sort}" for sort, character in self.movers.items())]

    def legend_line(self) -> str:
        """Returns the legend of boards with agents on them."""
        return "   ".join([*self.legend(), f"{ARROWS} agents"])

    def states(self, board: Board, snapshot: Snapshot) -> Iterator[tuple[Cell, str, int, State]]:
        """Yields each cell of the map with its kind, its number among the cells of its kind, and the words of its shown fields."""
        for kind, cells in board.cells.items():
            words = [
                [f.type.words[number] for number in snapshot.values[f"{kind}_{f.name}"].tolist()]
                for f in self.shown[kind]
            ]
            for number, cell in enumerate(cells):
                yield cell, kind, number, tuple(word[number] for word in words)


def make_letters(game: ir.Game) -> Letters:
    """Returns the characters of a game: its glyphs, and for states that no glyph stands for a letter of what sets them apart."""
    characters: dict[tuple[str, State], str] = {}
    shown: dict[str, tuple[ir.VarField, ...]] = {}
    for kind in game.kinds:
        fields = tuple(f for f in kind.fields if f.type.kind == "word" and not f.type.by)
        shown[kind.name] = (
            fields if prod(len(f.type.words) for f in fields) <= STATES else fields[:1]
        )
    movers = {sort.name: sort.glyph for sort in game.movers}
    for meaning in game.glyphs:
        starts = starts_of(game, meaning)
        characters.setdefault(
            (meaning.kind, tuple(str(starts[f.name]) for f in shown[meaning.kind])), meaning.glyph
        )
    for name, fields in shown.items():
        base = next((state for (kind, state) in characters if kind == name), ("",) * len(fields))
        for state in product(*(f.type.words for f in fields)):
            if (name, state) not in characters:
                differing = [word for word, usual in zip(state, base, strict=True) if word != usual]
                characters[name, state] = _free(differing, {*characters.values(), *movers.values()})
    return Letters(characters, shown, movers)


def _free(words: Sequence[str], used: Collection[str]) -> str:
    """Returns a character that is not used: the first letter of a word, small or large, one of its others, or any."""
    letters = "".join(word[0] + word[0].upper() for word in words) + "".join(words) + SPARE
    return next(
        (c for c in letters if c not in used and c not in ARROWS and c.isalnum()), NONE_LEFT
    )


def draw(letters: Letters, board: Board, world: World) -> list[str]:
    """Returns the map as it is, row by row; beside a row the numbers of its agents from left to right."""
    return board_rows(letters, board, snapshot_of(board.game, world, ()))


def board_rows(letters: Letters, board: Board, snapshot: Snapshot) -> list[str]:
    """Returns what `draw` does, of a moment of the interpreter or of the compiled game."""
    rows = [list(row) for row in board.game.rows]
    for cell, kind, _, state in letters.states(board, snapshot):
        rows[cell.row][cell.col] = letters.characters[kind, state]
    lines = with_figures(rows, snapshot, letters.movers, ARROWS)
    return [f"{line}  {' '.join(map(str, numbers))}".rstrip() for line, numbers in lines]


def with_figures(
    rows: list[list[str]], snapshot: Snapshot, movers: Mapping[str, str], arrows: str
) -> list[tuple[str, tuple[int, ...]]]:
    """Returns each row of cells with agents and movers on them, and the numbers of its agents from left to right.

    Args:
      rows: the characters of the cells, which are written over.
      movers: sort -> its character.
      arrows: of agents that face north, east, south, west.
    """
    beside: list[list[tuple[int, int]]] = [[] for _ in rows]
    for sort, number, row, col in snapshot.standing():
        rows[row][col] = arrows[snapshot.heading[number]] if sort == "agent" else movers[sort]
        if sort == "agent":
            beside[row].append((col, number))
    return [
        ("".join(row), tuple(agent for _, agent in sorted(own)))
        for row, own in zip(rows, beside, strict=True)
    ]
