"""Colours by name: those that files can use, usual colours of common words, and palettes for the rest.

Colours that tell words or agents apart differ for people with any kind of colour vision (tests simulate it).
"""

import re
import tomllib
from importlib.resources import files

from sjdsl.compiler import ir
from sjdsl.compiler.elaborate.looks import COLOURS as NAMED
from sjdsl.compiler.ir.queries import blocks_always

Colour = tuple[int, int, int]


def read_colour(text: str) -> Colour:
    """Returns the colour of a name that files know, or of `#rrggbb`."""
    code = NAMED.get(text, text)
    return int(code[1:3], 16), int(code[3:5], 16), int(code[5:7], 16)


def mixed(first: Colour, second: Colour, share: float) -> Colour:
    """Returns `first` with a share (0 .. 1) of `second`."""
    return tuple(round(a + (b - a) * share) for a, b in zip(first, second, strict=True))  # type: ignore[return-value]


def hexadecimal(colour: Colour) -> str:
    """Returns a colour as SVG and browsers read it: `#rrggbb`."""
    return "#{:02x}{:02x}{:02x}".format(*colour)


_LOOKS = tomllib.loads(
    files("sjdsl.render").joinpath("looks.toml").read_text(encoding="utf-8")
)  # where each list is explained


def _by_name(table: str) -> dict[str, Colour]:
    return {name: read_colour(colour) for name, colour in _LOOKS[table].items()}


def _in_order(colours: str) -> tuple[Colour, ...]:
    return tuple(map(read_colour, _LOOKS[colours]))


def _alike(table: str) -> dict[str, str]:
    """Returns the name that each word stands for."""
    return {word: name for name, words in _LOOKS[table].items() for word in words}


WORDS = {name: read_colour(name) for name in NAMED} | _by_name("words")
SPRITES, KINDS = _by_name("sprites"), _by_name("kinds")
ALIKE, PICTURED = _alike("alike"), _alike("pictured")
TILES, SOLID_TILES, MARKS, INKS, TINTS, AGENTS = map(
    _in_order, ("tiles", "solid_tiles", "marks", "inks", "tints", "agents")
)
COVERING = frozenset(
    {"wall", "water", "block", "table", "door"}
)  # sprites that leave nothing of the ground
FILLING = COVERING | {"floor"}  # sprites as large as their cell; the others stand in it
SHAPES = (
    "disc",
    "diamond",
    "square",
    "triangle",
    "ring",
    "cross",
    "hexagon",
    "wedge",
)  # sprites of words that have none of their own

PLANTS = frozenset(
    {"tree", "bush", "shrub", "oak", "hedge", "plant"}
)  # kinds that are told apart by what grows on one ground

# Words that are colours: a field with no others shows its first word like the rest.
COLOURS = frozenset({*NAMED, "gray"})

BARS = (
    INKS[7],
    *INKS[1:4],
)  # of the numbers of a cell, in order: at its foot, its head, its left and its right side

OUTSIDE: Colour = (250, 250, 250)
PALE: Colour = (214, 216, 220)  # of nobody's beam
INK: Colour = (34, 38, 44)
PAPER: Colour = (255, 255, 255)


def kind_colours(game: ir.Game, plain: tuple[str, ...] = (), main: str = "") -> dict[str, Colour]:
    """Returns the ground of each kind: what its name says, else the next of the palette; all but those of plants distinct if it can be.

    Args:
      plain: kinds that have the ground of kind `main`.
    """
    colours: dict[str, Colour] = {}
    for kind in (k for k in game.kinds if k.name not in plain):
        palette = SOLID_TILES if blocks_always(kind) else TILES
        if PLANTS & {*kind.name.split("_")}:
            colours[kind.name] = KINDS["ground"]
            continue
        parts = [ALIKE.get(part, part) for part in reversed(kind.name.split("_"))]
        wanted = [KINDS[part] for part in parts if part in KINDS] + [KINDS["sea"]] * (
            "water" in parts
        )
        free = [colour for colour in (*wanted, *palette) if colour not in colours.values()]
        colours[kind.name] = (free or palette)[0]
    return colours | dict.fromkeys(plain, colours.get(main, TILES[0]))


def tint_colours(words: tuple[str, ...]) -> tuple[Colour, ...]:
    """Returns the colour in which each word of a field tints its ground."""
    return word_colours(words, TINTS)


def word_colours(words: tuple[str, ...], inks: tuple[Colour, ...] = INKS) -> tuple[Colour, ...]:
    """Returns a colour for each word of a field; the first is plain and its colour only counts where all words have one."""
    spare = [ink for ink in inks if ink not in {WORDS.get(word) for word in words}]
    others = [word for word in words[1:] if word not in WORDS]
    numbers = {
        word: number
        for number, word in enumerate([*others, *(w for w in words[:1] if w not in WORDS)])
    }
    return tuple(
        WORDS[word] if word in WORDS else spare[numbers[word] % len(spare)] for word in words
    )


def mark_colours(labels: tuple[str, ...]) -> tuple[Colour, ...]:
    """Returns a colour for each marking phase: what its name says, else the next of the palette."""
    colours: list[Colour] = []
    for label in labels:
        free = [colour for colour in MARKS if colour not in colours]
        natural = next(
            (WORDS[part] for part in re.split(r"[^a-z0-9]+", label) if part in WORDS), None
        )
        colours.append(natural if natural and natural not in colours else (free or MARKS)[0])
    return tuple(colours)


def agent_colour(number: int) -> Colour:
    return AGENTS[number % len(AGENTS)]
