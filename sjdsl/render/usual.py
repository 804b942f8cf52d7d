"""Default appearance of kinds and words without a `look`: by their names, or by what the rules do with them."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import blocks_always, can_be, kinds_by_glyph, written_field
from sjdsl.render.colours import ALIKE, INK, INKS, SHAPES, SPRITES, WORDS, Colour, mixed, read_colour, word_colours

EATEN = ("apple", "gem", "coin", "mushroom", "ore")  # words that agents take, by their place

STANDING = {"forest": "tree", "rock": "ore"}  # what stops agents and is no wall, by what it is drawn like
DARKER = 0.35  # than its ground

SPAWNS = (SPRITES["floor"], *map(read_colour, ("purple", "brown", "blue")))  # of several kinds on which agents appear


@dataclass(frozen=True)
class Picture:
    """A sprite in a colour."""

    sprite: str
    colour: Colour


def main_kind(game: ir.Game) -> str:
    """Returns the kind that most of the open map is made of: the ground that all other things stand on."""
    kind_of = kinds_by_glyph(game)
    cells = Counter(kind_of[glyph] for row in game.rows for glyph in row)
    return max((kind.name for kind in game.kinds if not blocks_always(kind)), key=cells.__getitem__, default="")


def spawn_kinds(game: ir.Game) -> tuple[str, ...]:
    """Returns the kinds without fields on which agents are put, but for the one that most of the open map is made of."""
    targets = {kind for node in ir.walk(game) if isinstance(node, ir.Send) for kind in node.domain.var.kinds}
    main = main_kind(game)
    return tuple(kind.name for kind in game.kinds if not kind.fields and not kind.blocks and kind.name in targets and kind.name != main)


def usual_body(kind: ir.Kind, ground: Colour, spawns: tuple[str, ...]) -> Picture | None:
    """Returns the sprite of a whole cell: one with its name, a wall for what stops agents, a faint mark where agents appear."""
    like = next((ALIKE[part] for part in reversed(kind.name.split("_")) if part in ALIKE), "")
    if like == "water" or (like in STANDING and blocks_always(kind)):
        return Picture(STANDING.get(like, like), ground if like == "water" else mixed(ground, INK, DARKER))
    named = named_sprite(kind.name)
    if named is not None and named != "floor":
        return Picture(named, ground if named in ("wall", "water") else SPRITES[named])
    if blocks_always(kind):
        return Picture("wall", ground)
    return Picture("floor", SPAWNS[spawns.index(kind.name) % len(SPAWNS)]) if kind.name in spawns else None


def usual_movers(game: ir.Game) -> list[Picture]:
    """Returns the body of each sort of movers: the sprite with its name, else an animal; sorts with one sprite differ in colour."""
    found: list[Picture] = []
    for sort in game.movers:
        sprite = named_sprite(sort.name) or "animal"
        free = [colour for colour in (SPRITES[sprite], *INKS) if Picture(sprite, colour) not in found]
        found.append(Picture(sprite, (free or [SPRITES[sprite]])[0]))
    return found


def usual_words(field: ir.VarField, taken: bool, first: int = 0) -> tuple[Picture, ...]:
    """Returns the picture of each word of a field.

    Args:
      taken: agents change it where they stand, so it is an object.
      first: the plain shape of its second word, so that the fields of one kind have others.
    """
    of_field, colours = named_sprite(field.name), word_colours(field.type.words)
    found = []
    for number, (word, colour) in enumerate(zip(field.type.words, colours, strict=True)):
        of_word = named_sprite(word)
        cycle = EATEN if taken else SHAPES
        sprite = of_word or of_field or cycle[(number - 1 + (0 if taken else first)) % len(cycle)]
        found.append(Picture(sprite, SPRITES[sprite] if of_word and word not in WORDS else colour))
    return tuple(found)


def is_taken(name: str, kind: str, game: ir.Game) -> bool:
    """Returns whether agents change the field of the cell that they stand on."""
    for node in ir.walk(game):
        if isinstance(node, ir.Each | ir.Pick | ir.First) and node.domain.on is not None and kind in node.domain.on.kinds:
            cell = node.domain.on.name
            sets = (inner.target for inner in ir.walk(node) if isinstance(inner, ir.Set))
            if any(isinstance(t, ir.FieldRead) and t.name == name and getattr(t.owner, "name", "") == cell for t in sets):
                return True
    return False


def named_sprite(name: str) -> str | None:
    """Returns the sprite that a name, or the last part of it that does, speaks of."""
    return next((part for part in reversed(name.split("_")) if part in SPRITES), None)


def is_passing(field: ir.VarField, game: ir.Game) -> bool:
    """Returns whether a number or a set is gone at the end of every step: the last rule that writes it empties it wherever it is not."""
    written = [found for phase in game.schedule for found in _writes(phase, field, ())]
    match written[-1:]:
        case [(ir.Set(value=ir.Nobody() | ir.Number(value=0)), around)] if field.type.kind != "word":
            return all(_leaves_none_out(node, field) for node in around)
        case _:
            return False


def _writes(node: ir.Node, field: ir.VarField, around: tuple[ir.Node, ...]) -> Iterator[tuple[ir.Set | ir.Add, tuple[ir.Node, ...]]]:
    """Yields the statements that write a field, each with the statements around it."""
    if isinstance(node, ir.Set | ir.Add):
        if can_be(written_field(node.target), field):
            yield node, around
        return
    for child in ir.children(node):
        yield from _writes(child, field, (*around, node))


def _leaves_none_out(node: ir.Node, field: ir.VarField) -> bool:
    """Returns whether a statement reaches every cell or agent where the field holds something."""
    match node:
        case ir.Phase():
            return True
        case ir.Each(domain=domain) if domain.on is None and domain.restriction is None:
            reads = [] if domain.where is None else [n for n in ir.walk(domain.where) if isinstance(n, ir.FieldRead)]
            return all(read.name == field.name for read in reads)
        case _:
            return False
