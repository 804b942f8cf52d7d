"""Colours by name: those that files can use, of common words, and palettes for the rest.

Colours that tell enum values or agents apart differ for people with any kind of colour vision;
tests simulate it.
"""

import re
import tomllib
from importlib.resources import files
from itertools import cycle

from sjdsl.compiler import ir
from sjdsl.compiler.elaborate.looks import COLOURS as NAMED
from sjdsl.compiler.ir.queries import blocks_always

Colour = tuple[int, int, int]


def read_colour(text: str) -> Colour:
    """Returns the colour with a name that files can use, or of `#rrggbb`."""
    code = NAMED.get(text, text)
    return int(code[1:3], 16), int(code[3:5], 16), int(code[5:7], 16)


def mixed(first: Colour, second: Colour, share: float) -> Colour:
    """Returns `first` with a share (0 .. 1) of `second`."""
    red, green, blue = (round(a + (b - a) * share) for a, b in zip(first, second, strict=True))
    return red, green, blue


def hexadecimal(colour: Colour) -> str:
    """Returns a colour as SVG and browsers read it: `#rrggbb`."""
    return "#{:02x}{:02x}{:02x}".format(*colour)


# Its comments explain each table and list.
_LOOKS = tomllib.loads(files("sjdsl.render").joinpath("looks.toml").read_text(encoding="utf-8"))


def _colour_table(table: str) -> dict[str, Colour]:
    """Returns the colours of a table of `looks.toml` by name."""
    return {name: read_colour(colour) for name, colour in _LOOKS[table].items()}


def _palette(name: str) -> tuple[Colour, ...]:
    """Returns a list of colours of `looks.toml`."""
    return tuple(map(read_colour, _LOOKS[name]))


def _synonyms(table: str) -> dict[str, str]:
    """Returns the name that each word stands for."""
    return {word: name for name, words in _LOOKS[table].items() for word in words}


WORDS = {name: read_colour(name) for name in NAMED} | _colour_table("words")
SPRITES = _colour_table("sprites")
KINDS = _colour_table("kinds")
KIND_SYNONYMS = _synonyms("alike")
SPRITE_SYNONYMS = _synonyms("pictured")
TILES = _palette("tiles")
SOLID_TILES = _palette("solid_tiles")
MARKS = _palette("marks")
INKS = _palette("inks")
TINTS = _palette("tints")
AGENTS = _palette("agents")

# Sprites that hide the ground.
COVERING = frozenset({"wall", "water", "block", "table", "door"})
# Sprites as large as their cell; the others stand in it.
FILLING = COVERING | {"floor"}
# Sprites of enum values that have none of their own.
SHAPES = ("disc", "diamond", "square", "triangle", "ring", "cross", "hexagon", "wedge")
# Kinds that all have one ground and differ in what grows on it.
PLANTS = frozenset({"tree", "bush", "shrub", "oak", "hedge", "plant"})
# Enum values that are colours: a field with no others shows its first value like the rest.
COLOURS = frozenset({*NAMED, "gray"})
# Of the numbers of a cell, in order: at its foot, its head, its left and its right side.
BARS = (INKS[7], *INKS[1:4])

OUTSIDE: Colour = (250, 250, 250)
PALE: Colour = (214, 216, 220)  # of a beam that is nobody's
INK: Colour = (34, 38, 44)
PAPER: Colour = (255, 255, 255)


def kind_colours(game: ir.Game, plain: tuple[str, ...] = (), main: str = "") -> dict[str, Colour]:
    """Returns the colour of the ground of each kind: what its name says, else from a palette.

    While the palette lasts, no two kinds but plants have one colour.

    Args:
      plain: kinds that have the ground of kind `main`.
    """
    colours: dict[str, Colour] = {}
    for kind in game.kinds:
        parts = kind.name.split("_")
        if kind.name in plain:
            continue
        if PLANTS & {*parts}:
            colours[kind.name] = KINDS["ground"]
            continue
        parts = [KIND_SYNONYMS.get(part, part) for part in reversed(parts)]
        wanted = [KINDS[part] for part in parts if part in KINDS]
        if "water" in parts:
            wanted.append(KINDS["sea"])
        palette = SOLID_TILES if blocks_always(kind) else TILES
        free = [colour for colour in (*wanted, *palette) if colour not in colours.values()]
        colours[kind.name] = free[0] if free else palette[0]
    return colours | dict.fromkeys(plain, colours.get(main, TILES[0]))


def tint_colours(words: tuple[str, ...]) -> tuple[Colour, ...]:
    """Returns the colour in which each enum value of a field tints the ground."""
    return word_colours(words, TINTS)


def word_colours(words: tuple[str, ...], inks: tuple[Colour, ...] = INKS) -> tuple[Colour, ...]:
    """Returns a colour for each enum value: what its name says, else the next of `inks`.

    The first value, which is usually not drawn, is the last to get one.
    """
    colours = {word: WORDS[word] for word in words if word in WORDS}
    spare = [ink for ink in inks if ink not in colours.values()]
    unnamed = [word for word in (*words[1:], *words[:1]) if word not in WORDS]
    colours |= zip(unnamed, cycle(spare))
    return tuple(colours[word] for word in words)


def mark_colours(labels: tuple[str, ...]) -> tuple[Colour, ...]:
    """Returns a colour for each marking phase: what its name says, else the next of the palette."""
    colours: list[Colour] = []
    for label in labels:
        named = [WORDS[part] for part in re.split(r"[^a-z0-9]+", label) if part in WORDS]
        wanted = (*named[:1], *MARKS)
        free = [colour for colour in wanted if colour not in colours]
        colours.append(free[0] if free else MARKS[0])
    return tuple(colours)


def agent_colour(number: int) -> Colour:
    return AGENTS[number % len(AGENTS)]
