"""What kinds and enum values without a `look` look like.

Their names decide, or what the rules do with them.
"""

from collections import Counter
from dataclasses import dataclass

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import beginning_phases, blocks_always, kinds_by_glyph
from sjdsl.render.colours import (
    INK,
    INKS,
    KIND_SYNONYMS,
    SHAPES,
    SPRITE_SYNONYMS,
    SPRITES,
    WORDS,
    Colour,
    mixed,
    read_colour,
    word_colours,
)

# Sprites of enum values that agents take, in order.
TAKEN = ("apple", "gem", "coin", "mushroom", "ore")
# Sprites of kinds that stop agents and aren't walls.
OBSTACLES = {"forest": "tree", "rock": "ore"}
DARKER = 0.35  # how much darker an obstacle is than its ground
# Colours of the kinds on which agents start.
SPAWNS = (SPRITES["floor"], *map(read_colour, ("purple", "brown", "blue")))


@dataclass(frozen=True)
class Picture:
    """A sprite in a colour."""

    sprite: str
    colour: Colour


def main_kind(game: ir.Game) -> str:
    """Returns the kind that most of the open map is made of, as ground of all other things."""
    kind_of = kinds_by_glyph(game)
    cells = Counter(kind_of[glyph] for row in game.rows for glyph in row)
    return max(
        (kind.name for kind in game.kinds if not blocks_always(kind)),
        key=cells.__getitem__,
        default="",
    )


def spawn_kinds(game: ir.Game) -> tuple[str, ...]:
    """Returns the kinds on which agents start and that have no fields, except the main kind."""
    targets: set[str] = set()
    for phase in beginning_phases(game):
        for node in ir.walk(phase):
            if isinstance(node, ir.Send):
                targets |= {*node.domain.var.kinds}
    main = main_kind(game)
    return tuple(
        kind.name
        for kind in game.kinds
        if not kind.fields and not kind.blocks and kind.name in targets and kind.name != main
    )


def usual_body(kind: ir.Kind, ground: Colour, spawns: tuple[str, ...]) -> Picture | None:
    """Returns the sprite of a whole cell, None if only its ground is drawn.

    It is the sprite that the name of the kind mentions, else a block for what stops agents and a
    faint mark where they start.
    """
    parts = reversed(kind.name.split("_"))
    meaning = next((KIND_SYNONYMS[part] for part in parts if part in KIND_SYNONYMS), "")
    if meaning == "water":
        return Picture("water", ground)
    if meaning in OBSTACLES and blocks_always(kind):
        return Picture(OBSTACLES[meaning], mixed(ground, INK, DARKER))
    sprite = named_sprite(kind.name)
    if sprite in ("wall", "water"):
        return Picture(sprite, ground)
    if sprite is not None and sprite != "floor":
        return Picture(sprite, SPRITES[sprite])
    if blocks_always(kind):
        return Picture("block", ground)
    if kind.name in spawns:
        return Picture("floor", SPAWNS[spawns.index(kind.name) % len(SPAWNS)])
    return None


def usual_movers(game: ir.Game) -> list[Picture]:
    """Returns the body of each type of mover: the sprite that its name mentions, else an animal.

    Types with one sprite differ in colour while there are colours left.
    """
    bodies: list[Picture] = []
    for mover in game.movers:
        sprite = named_sprite(mover.name) or "animal"
        usual = Picture(sprite, SPRITES[sprite])
        choices = [usual, *(Picture(sprite, ink) for ink in INKS)]
        bodies.append(next((body for body in choices if body not in bodies), usual))
    return bodies


def usual_words(field: ir.VarField, taken: bool, first: int = 0) -> tuple[Picture, ...]:
    """Returns the picture of each enum value of a field.

    Args:
      taken: whether agents change it where they stand, so that it is an object.
      first: the index of the shape of its second value, to differ from other fields of the kind.
    """
    words = field.type.words
    field_sprite = named_sprite(field.name)
    pictures: list[Picture] = []
    for number, (word, colour) in enumerate(zip(words, word_colours(words), strict=True)):
        word_sprite = named_sprite(word)
        if taken:
            unnamed = TAKEN[(number - 1) % len(TAKEN)]
        else:
            unnamed = SHAPES[(number - 1 + first) % len(SHAPES)]
        sprite = word_sprite or field_sprite or unnamed
        is_named = word_sprite is not None or (field_sprite is not None and len(words) == 2)
        picture = Picture(sprite, colour)
        if is_named and word not in WORDS:
            usual = Picture(sprite, SPRITES[sprite])
            picture = picture if usual in pictures[1:] else usual
        pictures.append(picture)
    return tuple(pictures)


def is_taken(name: str, kind: str, game: ir.Game) -> bool:
    """Returns whether agents change a field of the cell that they stand on."""
    for node in ir.walk(game):
        cell = node.domain.on if isinstance(node, ir.Each | ir.Pick | ir.First) else None
        if cell is None or kind not in cell.kinds:
            continue
        for inner in ir.walk(node):
            match inner:
                case ir.Set(target=ir.FieldRead(name=target, owner=ir.Member(name=owner))):
                    if target == name and owner == cell.name:
                        return True
    return False


def named_sprite(name: str) -> str | None:
    """Returns the sprite that a name mentions: the last of its parts that names one."""
    parts = (SPRITE_SYNONYMS.get(part, part) for part in reversed(name.split("_")))
    return next((part for part in parts if part in SPRITES), None)
