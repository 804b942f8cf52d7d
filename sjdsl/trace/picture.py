"""Small pictures of a map: a character for each state of a cell and each sort of movers, arrows for agents, numbers beside the rows."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import starts_of
from sjdsl.interpreter.board import Board
from sjdsl.interpreter.state import Value, World

ARROWS = "^>v<"
STATES = 12  # of one kind that get a character of their own; of a kind with more only its first field is shown
SPARE = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
NONE_LEFT = "?"

State = tuple[tuple[str, Value], ...]  # (field, word) for each field that is shown


@dataclass(frozen=True)
class Looks:
    """characters: (kind, its shown fields) -> the character of such a cell. movers: sort -> its character."""

    characters: Mapping[tuple[str, State], str]
    shown: Mapping[str, tuple[str, ...]]
    movers: Mapping[str, str]

    def legend(self) -> list[str]:
        """Returns what each character stands for: `r soil: ripe`."""
        said = []
        for (kind, state), character in self.characters.items():
            words = ", ".join(str(word) for _, word in state)
            said.append(f"{character} {kind}: {words}" if words else f"{character} {kind}")
        return [*said, *(f"{character} {sort}" for sort, character in self.movers.items())]


def make_looks(game: ir.Game) -> Looks:
    """Returns the characters of a game: its glyphs, and for states that no glyph stands for a letter of what sets them apart."""
    characters: dict[tuple[str, State], str] = {}
    shown = {kind.name: _shown(kind) for kind in game.kinds}
    movers = {sort.name: sort.glyph for sort in game.movers}
    for meaning in game.glyphs:
        starts = starts_of(game, meaning)
        characters.setdefault((meaning.kind, tuple((name, starts[name]) for name in shown[meaning.kind])), meaning.glyph)
    for kind in game.kinds:
        base = next((dict(state) for (name, state) in characters if name == kind.name), {})
        words = [[(f.name, word) for word in f.type.words] for f in kind.fields if f.name in shown[kind.name]]
        for state in product(*words):
            if (kind.name, state) not in characters:
                characters[kind.name, state] = _free(
                    [w for name, w in state if base.get(name) != w], {*characters.values(), *movers.values()}
                )
    return Looks(characters, shown, movers)


def _shown(kind: ir.Kind) -> tuple[str, ...]:
    fields = [f for f in kind.fields if f.type.kind == "word" and not f.type.by]
    count = 1
    for field in fields:
        count *= len(field.type.words)
    return tuple(f.name for f in (fields if count <= STATES else fields[:1]))


def _free(words: Sequence[str], used: Collection[str]) -> str:
    """Returns a character that is not used: the first letter of a word, small or large, one of its others, or any."""
    letters = "".join(word[0] + word[0].upper() for word in words) + "".join(words) + SPARE
    return next((c for c in letters if c not in used and c not in ARROWS and c.isalnum()), NONE_LEFT)


def draw(looks: Looks, board: Board, world: World) -> list[str]:
    """Returns the map as it is, row by row; beside a row the numbers of its agents from left to right."""
    rows = [list(row) for row in board.game.rows]
    for cell, kind in board.kind_of.items():
        state = tuple((name, world.cells[kind, name][board.number[cell]]) for name in looks.shown[kind])
        rows[cell.row][cell.col] = looks.characters[kind, state]
    lines = with_figures(rows, world, looks.movers, ARROWS)
    return [f"{line}  {' '.join(map(str, numbers))}".rstrip() for line, numbers in lines]


def with_figures(rows: list[list[str]], world: World, movers: Mapping[str, str], arrows: str) -> list[tuple[str, tuple[int, ...]]]:
    """Returns each row of cells with movers and agents on them, and the numbers of its agents from left to right.

    Args:
      rows: the characters of the cells, which are written over.
      movers: sort -> its character.
      arrows: of agents that face north, east, south, west.
    """
    for sort, character in movers.items():
        for at in world.movers[sort].position:
            if at is not None:
                rows[at.row][at.col] = character
    beside: list[list[tuple[int, int]]] = [[] for _ in rows]
    for agent, place in enumerate(world.position):
        if place is not None:
            rows[place.row][place.col] = arrows[world.heading[agent]]
            beside[place.row].append((place.col, agent))
    return [("".join(row), tuple(agent for _, agent in sorted(own))) for row, own in zip(rows, beside, strict=True)]
