"""Colours: the natural ones of common words, and palettes for everything else."""

import re

from sjdsl.compiler import ir

Colour = tuple[int, int, int]

# Words of fields and names of phases that mark, and the colour most people would give them.
WORDS: dict[str, Colour] = {
    "red": (214, 69, 65),
    "green": (62, 150, 81),
    "blue": (57, 106, 177),
    "orange": (230, 134, 38),
    "yellow": (230, 190, 40),
    "purple": (131, 84, 168),
    "pink": (222, 120, 160),
    "brown": (140, 98, 57),
    "black": (40, 40, 40),
    "white": (245, 245, 245),
    "grey": (140, 140, 140),
    "gray": (140, 140, 140),
    "ripe": (196, 54, 44),
    "dirty": (122, 84, 46),
    "polluted": (122, 84, 46),
    "iron": (94, 108, 128),
    "gold": (232, 185, 35),
    "partial": (240, 218, 140),
    "silver": (176, 184, 194),
    "copper": (184, 115, 51),
    "coop": (76, 158, 110),
    "cooperate": (76, 158, 110),
    "defect": (200, 76, 72),
    "raw": (134, 98, 62),
    "cut": (104, 160, 196),
    "fine": (150, 96, 190),
    "poison": (120, 60, 140),
    "fire": (240, 120, 40),
    "zap": (240, 120, 40),
    "scrub": (80, 190, 235),
    "clean": (80, 190, 235),
    "mine": (250, 214, 80),
    "give": (235, 120, 190),
    "offer": (235, 120, 190),
}

# Names of kinds of cells, by the part of the name that says what it is.
KINDS: dict[str, Colour] = {
    "wall": (86, 92, 102),
    "water": (164, 200, 224),
    "river": (164, 200, 224),
    "channel": (140, 182, 212),
    "sea": (140, 182, 212),
    "grass": (214, 226, 196),
    "orchard": (200, 220, 178),
    "forest": (178, 204, 160),
    "soil": (226, 214, 190),
    "ground": (226, 216, 198),
    "sand": (238, 228, 200),
    "floor": (236, 234, 228),
    "rock": (216, 210, 204),
    "stone": (202, 200, 200),
    "brick": (190, 166, 150),
    "tile": (232, 230, 226),
    "gate": (228, 222, 238),
    "camp": (228, 222, 238),
    "corner": (228, 222, 238),
    "den": (236, 218, 226),
    "home": (228, 222, 238),
}

# Words that are colours: a field with no others shows its first word like the rest.
COLOURS = frozenset({"red", "green", "blue", "orange", "yellow", "purple", "pink", "brown", "black", "white", "grey", "gray"})

TILES: tuple[Colour, ...] = (
    (236, 234, 228),
    (222, 230, 214),
    (228, 222, 238),
    (238, 226, 208),
    (212, 226, 232),
    (236, 218, 222),
    (220, 222, 210),
    (226, 230, 240),
)
SOLID_TILES: tuple[Colour, ...] = ((86, 92, 102), (112, 100, 92), (84, 104, 100), (104, 94, 116))
MARKS: tuple[Colour, ...] = (
    (240, 120, 40),
    (80, 190, 235),
    (235, 120, 190),
    (250, 214, 80),
    (120, 200, 120),
    (160, 130, 220),
)
INKS: tuple[Colour, ...] = (
    (57, 106, 177),
    (218, 124, 48),
    (62, 150, 81),
    (204, 57, 73),
    (107, 76, 154),
    (146, 114, 36),
    (30, 140, 150),
    (90, 90, 100),
)
AGENTS: tuple[Colour, ...] = (
    (230, 75, 53),
    (0, 114, 178),
    (0, 158, 115),
    (230, 159, 0),
    (148, 80, 180),
    (86, 180, 233),
    (214, 100, 160),
    (120, 110, 60),
    (60, 60, 150),
    (150, 200, 60),
    (120, 70, 50),
    (100, 110, 120),
)
OUTSIDE: Colour = (250, 250, 250)
INK: Colour = (52, 56, 64)
PAPER: Colour = (255, 255, 255)


def kind_colours(game: ir.Game) -> dict[str, Colour]:
    """Returns the tile colour of each kind: what its name says, else the next of the palette; all distinct if it can be."""
    colours: dict[str, Colour] = {}
    for kind in game.kinds:
        solid = any(block.what == "agents" and block.condition is None for block in kind.blocks)
        palette = SOLID_TILES if solid else TILES
        wanted = [KINDS[part] for part in reversed(kind.name.split("_")) if part in KINDS]
        free = [colour for colour in (*wanted, *palette) if colour not in colours.values()]
        colours[kind.name] = (free or palette)[0]
    return colours


def word_colours(words: tuple[str, ...]) -> tuple[Colour, ...]:
    """Returns a colour for each word of a field; the first is plain and its colour only counts where all words have one."""
    spare = [ink for ink in INKS if ink not in {WORDS.get(word) for word in words}]
    return tuple(WORDS[word] if word in WORDS else spare[index % len(spare)] for index, word in enumerate(words))


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
