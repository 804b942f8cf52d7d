"""Colours by name: those that files can use, usual colours of common words, and palettes for the rest.

Colours that tell words or agents apart differ for people with any kind of colour vision (tests simulate it).
"""

import re

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
    """Returns a colour as SVG, browsers and terminals read it: `#rrggbb`."""
    return "#{:02x}{:02x}{:02x}".format(*colour)


# Words of fields and names of phases that mark, and the colour most people would give them.
WORDS: dict[str, Colour] = {
    **{name: read_colour(name) for name in NAMED},
    "gray": read_colour("grey"),
    "ripe": read_colour("red"),
    **dict.fromkeys(("unripe", "growing", "young"), (166, 196, 120)),
    "dirty": (104, 72, 40),
    "polluted": (104, 72, 40),
    "iron": (150, 164, 184),
    "gold": (240, 190, 30),
    "silver": (190, 198, 206),
    "copper": (190, 110, 50),
    "raw": (140, 90, 43),
    "cut": (86, 180, 233),
    "fine": (106, 61, 154),
    "poison": (106, 61, 154),
    "coop": read_colour("blue"),
    "cooperate": read_colour("blue"),
    "defect": read_colour("orange"),
    "fire": (240, 120, 40),
    "zap": (240, 120, 40),
    "scrub": (80, 190, 235),
    "clean": (80, 190, 235),
    "mine": (250, 214, 80),
    "give": (235, 120, 190),
    "offer": (235, 120, 190),
}

# Sprites and the colour each has unless it is given one.
SPRITES: dict[str, Colour] = {
    "tree": (58, 132, 72),
    "bush": (58, 132, 72),
    "apple": read_colour("red"),
    "water": (164, 204, 230),
    "mushroom": read_colour("red"),
    "ore": (240, 190, 30),
    "gem": read_colour("blue"),
    "coin": read_colour("orange"),
    "wall": (96, 102, 112),
    "floor": (120, 126, 136),
    "animal": (160, 102, 44),
    "raft": (168, 116, 63),
    "pot": (74, 79, 88),
    "banana": read_colour("yellow"),
    "flag": read_colour("red"),
    "boat": (140, 90, 43),
    "cart": read_colour("blue"),
    "crate": (176, 130, 76),
    "cube": (150, 164, 184),
    "door": (140, 90, 43),
    "block": (122, 126, 134),
    "table": (206, 178, 138),
    "plate": (236, 238, 240),
}

COVERING = frozenset({"wall", "water", "block", "table", "door"})  # sprites that leave nothing of the ground
FILLING = COVERING | {"floor"}  # sprites as large as their cell; the others stand in it
SHAPES = ("disc", "diamond", "square", "triangle", "ring", "cross", "hexagon", "wedge")  # sprites of words that have none of their own

# Grounds by the part of a kind's name that says what it is: pale, so that what stands there is seen first; they differ in brightness, too,
# so that the colour-blind tell grass from an orchard.
KINDS: dict[str, Colour] = {
    "wall": (96, 102, 112),
    "water": (164, 204, 230),
    "river": (164, 204, 230),
    "channel": (112, 168, 216),
    "sea": (112, 168, 216),
    "grass": (206, 226, 172),
    "orchard": (172, 200, 124),
    "forest": (140, 178, 120),
    "soil": (208, 186, 150),
    "ground": (234, 220, 202),
    "sand": (252, 240, 176),
    "floor": (238, 236, 231),
    "rock": (204, 197, 190),
    "stone": (168, 172, 180),
    "brick": (180, 124, 98),
    "tile": (234, 232, 228),
}

# Parts of kinds' names that are drawn as another one is.
ALIKE: dict[str, str] = {
    **dict.fromkeys(("lake", "pond", "pool", "stream", "brook", "canal", "moat", "bay", "ocean", "swamp", "puddle"), "water"),
    **dict.fromkeys(("land", "meadow", "lawn", "plain", "garden", "park", "pasture"), "grass"),
    **dict.fromkeys(("earth", "dirt", "mud", "path", "road", "farm"), "soil"),
    **dict.fromkeys(("bush", "shrub", "tree", "oak", "plant", "crop"), "ground"),
    **dict.fromkeys(("beach", "desert", "dune", "coast"), "sand"),
    **dict.fromkeys(("thicket", "woods", "wood", "jungle"), "forest"),
    **dict.fromkeys(("cliff", "mountain", "boulder", "hill", "crag"), "rock"),
}

# Words that are colours: a field with no others shows its first word like the rest.
COLOURS = frozenset({*NAMED, "gray"})

TILES: tuple[Colour, ...] = (  # none is blue, as water is
    (238, 236, 231),
    (244, 222, 176),
    (244, 210, 212),
    (206, 171, 150),
    (192, 171, 185),
    (220, 192, 150),
    (199, 185, 178),
    (208, 228, 196),
)
SOLID_TILES: tuple[Colour, ...] = ((96, 102, 112), (122, 108, 98), (92, 114, 108), (112, 102, 126))
MARKS: tuple[Colour, ...] = (
    (240, 120, 40),
    (80, 190, 235),
    (235, 120, 190),
    (250, 214, 80),
    (0, 158, 115),
    (160, 130, 220),
)
# For words that name no colour: Okabe and Ito's, in an order that keeps neighbours far apart.
INKS: tuple[Colour, ...] = tuple(map(read_colour, ("blue", "orange", "green", "pink", "sky", "brown", "purple", "black")))

# Grounds of words without a colour: none is blue, as water is.
TINTS: tuple[Colour, ...] = tuple(map(read_colour, ("orange", "pink", "brown", "green", "purple", "black")))

BARS = (INKS[7], *INKS[1:4])  # of the numbers of a cell, in order: at its foot, its head, its left and its right side

# An own colour for each agent a game can have: Okabe and Ito's, then those farthest from all before them, by the smallest CIE76
# distance as people with normal colour vision, deuteranopes and protanopes see them (Machado, Oliveira and Fernandes 2009).
_AGENTS = (
    "d55e00 0072b2 009e73 e69f00 6a3d9a 56b4e9 cc79a7 f0e442 1414f8 802014 8cec98 5c68f8 5c3850 f8c8d4 ec1450 3820bc "
    "f8985c 5098f8 b03814 683874 5cc88c bcd4f8 5c7444 8c5c74 5044bc 5c44f8 f8c85c 742c2c 14bcc8 80bca4 8c5c8c d46838 "
    "3874d4 80ecb0 2c8cbc f88038 2014d4 68a468 5098e0 5c2098 14d474 8cec80 983850 5c80f8 5044d4 a4382c 50bc50 f88cc8 "
    "e0c838 209898 741480 984498 d42cb0 209880 4468e0 684468 8cd4b0 c84414 8cc8f8 385038 38ecd4 2074a4 442cb0 a45c2c"
)
AGENTS: tuple[Colour, ...] = tuple(read_colour(f"#{code}") for code in _AGENTS.split())
OUTSIDE: Colour = (250, 250, 250)
PALE: Colour = (214, 216, 220)  # of nobody's beam
INK: Colour = (34, 38, 44)
PAPER: Colour = (255, 255, 255)


def kind_colours(game: ir.Game, plain: tuple[str, ...] = (), main: str = "") -> dict[str, Colour]:
    """Returns the ground of each kind: what its name says, else the next of the palette; all distinct if it can be.

    Args:
      plain: kinds that have the ground of kind `main`.
    """
    colours: dict[str, Colour] = {}
    for kind in (k for k in game.kinds if k.name not in plain):
        palette = SOLID_TILES if blocks_always(kind) else TILES
        parts = [ALIKE.get(part, part) for part in reversed(kind.name.split("_"))]
        wanted = [KINDS[part] for part in parts if part in KINDS] + [KINDS["sea"]] * ("water" in parts)
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
    numbers = {word: number for number, word in enumerate([*others, *(w for w in words[:1] if w not in WORDS)])}
    return tuple(WORDS[word] if word in WORDS else spare[numbers[word] % len(spare)] for word in words)


def mark_colours(labels: tuple[str, ...]) -> tuple[Colour, ...]:
    """Returns a colour for each marking phase: what its name says, else the next of the palette."""
    colours: list[Colour] = []
    for label in labels:
        free = [colour for colour in MARKS if colour not in colours]
        natural = next((WORDS[part] for part in re.split(r"[^a-z0-9]+", label) if part in WORDS), None)
        colours.append(natural if natural and natural not in colours else (free or MARKS)[0])
    return tuple(colours)


def agent_colour(number: int) -> Colour:
    return AGENTS[number % len(AGENTS)]
