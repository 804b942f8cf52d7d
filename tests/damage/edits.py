"""Single edits of a game, as they happen at a keyboard: one token deleted, swapped, written twice, misspelt; a number changed; a map row cut."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from random import Random
from string import ascii_lowercase

from lark import Token

from sjdsl.compiler.syntax.parse import read_tree
from sjdsl.compiler.syntax.read import read_source

FOLDER = Path(__file__).parents[2] / "games"

GAMES = (
    "coins", "harvest_open", "harvest_closed", "harvest_partnership", "clean_up", "coop_mining", "mushrooms", "gift_refinement", "pd_arena",
)  # fmt: skip
KINDS = ("delete", "swap", "duplicate", "misspell", "number", "row")


@dataclass(frozen=True)
class Edit:
    """One damaged file of a game: `lines` are those edited in the new `text` of `file`; `before` and `after` say what was done."""

    game: str
    kind: str
    file: str
    text: str
    lines: tuple[int, ...]
    before: str
    after: str
    tokens: tuple[Token, ...] = ()


def edit(game: str, kind: str, random: Random) -> Edit:
    """Returns a random edit of one kind."""
    return _row(game, random) if kind == "row" else _token(game, kind, random)


@cache
def tokens(game: str) -> tuple[str, tuple[Token, ...]]:
    """Returns the text of a game and its tokens."""
    source = read_source(FOLDER / f"{game}.sj")
    return source.text, tuple(read_tree(source)[0])


def _token(game: str, kind: str, random: Random) -> Edit:
    text, found = tokens(game)
    while True:
        number = random.randrange(len(found) - 1)
        one, two = found[number], found[number + 1]
        start, end, edited = one.start_pos or 0, one.end_pos or 0, (one,)
        match kind:
            case "delete":
                new = ""
            case "duplicate":
                new = f"{one} {one}"
            case "swap":
                new, edited = f"{two}{text[end : two.start_pos]}{one}", (one, two)
                end = two.end_pos or 0
            case "misspell":
                new = misspelt(str(one), random)
            case _:
                new = another_number(str(one), random) if one.type in ("INT", "DEC") else str(one)
        old = text[start:end]
        if new.split() != old.split():
            lines = tuple(dict.fromkeys(token.line or 0 for token in edited))
            return Edit(
                game, kind, f"{game}.sj", text[:start] + new + text[end:], lines, old, new, edited
            )


def misspelt(word: str, random: Random) -> str:
    """Returns a word with one letter lost, doubled, exchanged with its neighbour or mistaken; a text keeps its quotes."""
    low, high = (1, len(word) - 1) if word[0] == '"' else (0, len(word))
    if high - low < 1:
        return word
    at = random.randrange(low, high)
    match random.randrange(4):
        case 0:
            return word[:at] + word[at + 1 :]
        case 1:
            return word[: at + 1] + word[at:]
        case 2 if at + 1 < high:
            return word[:at] + word[at + 1] + word[at] + word[at + 2 :]
        case _:
            return word[:at] + random.choice(ascii_lowercase) + word[at + 1 :]


def another_number(digits: str, random: Random) -> str:
    """Returns a number of another value: one more or less, ten times or a tenth of it, or none."""
    value = float(digits) if "." in digits else int(digits)
    others = [value + 1, max(0, value - 1), value * 10, value / 10, 0, value + 0.5]
    new = random.choice([other for other in others if other != value])
    return f"{new:.10f}".rstrip("0").rstrip(".")


def maps(game: str) -> list[str]:
    """Returns the map files a game names."""
    return [
        str(token)[1:-1]
        for token in tokens(game)[1]
        if token.type == "STRING" and str(token).endswith('.txt"')
    ]


def _row(game: str, random: Random) -> Edit:
    """A row of a map too few, a row cut short, a row with one character too many or another one."""
    file = random.choice(maps(game)) if maps(game) else ""
    rows = (FOLDER / file).read_text("utf-8").splitlines()
    number = random.randrange(len(rows))
    row = rows[number]
    at = random.randrange(len(row))
    new: str | None
    match random.randrange(4):
        case 0:
            new = None
        case 1:
            new = row[:at]
        case 2:
            new = row[:at] + row[at + 1 :]
        case _:
            new = row[:at] + random.choice([c for c in "?x.#P" if c != row[at]]) + row[at + 1 :]
    left = [*rows[:number], *([] if new is None else [new]), *rows[number + 1 :]]
    return Edit(game, "row", file, "\n".join(left) + "\n", (number + 1,), row, new or "")


def place(edited: Edit) -> str:
    """Returns where an edit is, and what it is, for a person."""
    return f"{Path(edited.file).as_posix()}:{edited.lines[0]}: {edited.kind} `{edited.before}` -> `{edited.after}`"
