"""Default appearance of kinds and words without a `look`: by their names, or by what the rules do with them."""

from collections import Counter
from dataclasses import dataclass

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import blocks_always, kinds_by_glyph
from sjdsl.render.colours import (
    ALIKE,
    INK,
    INKS,
    PICTURED,
    SHAPES,
    SPRITES,
    WORDS,
    Colour,
    mixed,
    read_colour,
    word_colours,
)

EATEN = ("apple", "gem", "coin", "mushroom", "ore")  # words that agents take, by their place

STANDING = {
    "forest": "tree",
    "rock": "ore",
}  # what stops agents and is no wall, by what it is drawn like
DARKER = 0.35  # than its ground

SPAWNS = (
    SPRITES["floor"],
    *map(read_colour, ("purple", "brown", "blue")),
)  # of several kinds on which agents appear


@dataclass(frozen=True)
class Picture:
    """A sprite in a colour."""

    sprite: str
    colour: Colour


def main_kind(game: ir.Game) -> str:
    """Returns the kind that most of the open map is made of: the ground that all other things stand on."""
    kind_of = kinds_by_glyph(game)
    cells = Counter(kind_of[glyph] for row in game.rows for glyph in row)
    return max(
        (kind.name for kind in game.kinds if not blocks_always(kind)),
        key=cells.__getitem__,
        default="",
    )


def spawn_kinds(game: ir.Game) -> tuple[str, ...]:
    """Returns the kinds without fields on which agents are put at the start, but for the one that most of the open map is made of."""
    targets = {
        kind
        for node in ir.walk(game.start)
        if isinstance(node, ir.Send)
        for kind in node.domain.var.kinds
    }
    main = main_kind(game)
    return tuple(
        kind.name
        for kind in game.kinds
        if not kind.fields and not kind.blocks and kind.name in targets and kind.name != main
    )


def usual_body(kind: ir.Kind, ground: Colour, spawns: tuple[str, ...]) -> Picture | None:
    """Returns the sprite of a whole cell: one with its name, a wall or a block for what stops agents, a faint mark where they start."""
    like = next((ALIKE[part] for part in reversed(kind.name.split("_")) if part in ALIKE), "")
    if like == "water" or (like in STANDING and blocks_always(kind)):
        return Picture(
            STANDING.get(like, like), ground if like == "water" else mixed(ground, INK, DARKER)
        )
    named = named_sprite(kind.name)
    if named is not None and named != "floor":
        return Picture(named, ground if named in ("wall", "water") else SPRITES[named])
    if blocks_always(kind):
        return Picture("block", ground)
    return (
        Picture("floor", SPAWNS[spawns.index(kind.name) % len(SPAWNS)])
        if kind.name in spawns
        else None
    )


def usual_movers(game: ir.Game) -> list[Picture]:
    """Returns the body of each sort of movers: the sprite with its name, else an animal; sorts with one sprite differ in colour."""
    found: list[Picture] = []
    for sort in game.movers:
        sprite = named_sprite(sort.name) or "animal"
        free = [
            colour for colour in (SPRITES[sprite], *INKS) if Picture(sprite, colour) not in found
        ]
        found.append(Picture(sprite, (free or [SPRITES[sprite]])[0]))
    return found


def usual_words(field: ir.VarField, taken: bool, first: int = 0) -> tuple[Picture, ...]:
    """Returns the picture of each word of a field.

    Args:
      taken: agents change it where they stand, so it is an object.
      first: the plain shape of its second word, so that the fields of one kind have others.
    """
    of_field, colours = named_sprite(field.name), word_colours(field.type.words)
    found: list[Picture] = []
    for number, (word, colour) in enumerate(zip(field.type.words, colours, strict=True)):
        of_word = named_sprite(word)
        cycle = EATEN if taken else SHAPES
        sprite = of_word or of_field or cycle[(number - 1 + (0 if taken else first)) % len(cycle)]
        says_it = word not in WORDS and (
            of_word is not None or (of_field is not None and len(field.type.words) == 2)
        )
        own = Picture(sprite, SPRITES[sprite]) if says_it else None
        found.append(own if own is not None and own not in found[1:] else Picture(sprite, colour))
    return tuple(found)


def is_taken(name: str, kind: str, game: ir.Game) -> bool:
    """Returns whether agents change the field of the cell that they stand on."""
    for node in ir.walk(game):
        if (
            isinstance(node, ir.Each | ir.Pick | ir.First)
            and node.domain.on is not None
            and kind in node.domain.on.kinds
        ):
            cell = node.domain.on.name
            sets = (inner.target for inner in ir.walk(node) if isinstance(inner, ir.Set))
            if any(
                isinstance(t, ir.FieldRead)
                and t.name == name
                and getattr(t.owner, "name", "") == cell
                for t in sets
            ):
                return True
    return False


def named_sprite(name: str) -> str | None:
    """Returns the sprite that a name mentions: the last of its parts that names one."""
    parts = (PICTURED.get(part, part) for part in reversed(name.split("_")))
    return next((part for part in parts if part in SPRITES), None)
