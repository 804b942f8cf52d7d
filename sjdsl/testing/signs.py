"""The characters of a test's picture.

Glyphs of the map and of movers, `looks` of the test's author, arrows for agents.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import kind_named
from sjdsl.near_names import meant
from sjdsl.testing.values import from_author

# The first that isn't a sign is drawn for a cell whose state has no sign.
UNKNOWN = "?!*%$"


@dataclass(frozen=True)
class Sign:
    """A character that stands for a kind of cell whose fields have certain values.

    These are in the interpreter's form.
    """

    character: str
    kind: str
    values: Mapping[str, Any] = field(default_factory=dict)

    def __str__(self) -> str:
        return " ".join([self.kind, *(f"{name}={value}" for name, value in self.values.items())])


@dataclass(frozen=True)
class Signs:
    """All signs of a stage."""

    game: ir.Game
    by_character: Mapping[str, Sign]  # the author's looks before the glyphs
    arrows: str  # agents facing north, east, south, west
    movers: Mapping[str, str] = field(default_factory=dict)  # character -> entity type

    def is_body(self, character: str) -> bool:
        """Returns whether a character is an agent or a mover, which hides its cell."""
        return character in self.arrows or character in self.movers

    def draw(self, kind: str, values: Mapping[str, Any]) -> str:
        """Returns the sign of a cell with these values: the fitting one with most fields."""
        fitting = [sign for sign in self._of_kind(kind) if sign.values.items() <= values.items()]
        if not fitting:
            return next(c for c in UNKNOWN if c not in self.by_character)
        return max(fitting, key=lambda sign: len(sign.values)).character

    def fields_of(self, kind: str) -> set[str]:
        """Returns the fields for which some sign of a kind has a value."""
        return {name for sign in self._of_kind(kind) for name in sign.values}

    def _of_kind(self, kind: str) -> list[Sign]:
        return [sign for sign in self.by_character.values() if sign.kind == kind]

    def meaning(self, character: str, glyph: str) -> dict[str, Any]:
        """Returns the values of a cell that has a sign in a picture, and a glyph on the map.

        Fields without a value in the sign are as the glyph says.
        """
        return {**self.by_character[glyph].values, **self.by_character[character].values}


def make_signs(game: ir.Game, looks: Mapping[str, str], arrows: str) -> Signs:
    """Returns the signs of a game.

    Args:
      looks: character -> what it stands for, as `"tree fruit=none"`.

    Raises:
      ValueError: a character is there twice or can't be used, or the game lacks a kind, field or
        value.
    """
    if len(set(arrows)) != 4:
        raise ValueError(
            "`arrows` are four different characters, for north, east, south and west, "
            f"not {arrows!r}"
        )
    signs = {character: _read_look(game, character, text) for character, text in looks.items()}
    glyphs = {glyph.glyph: glyph for glyph in game.glyphs}
    movers = {movers.glyph: movers.name for movers in game.movers}
    for character in (*signs, *glyphs, *movers):
        if character in arrows:
            meaning = f"a `{movers[character]}`" if character in movers else "a cell"
            raise ValueError(
                f"`{character}` is an arrow of an agent and stands for {meaning}: "
                "give the stage other `arrows`, four characters"
            )
    for character, sign in signs.items():
        if character in movers:
            raise ValueError(
                f"`{character}` stands for the movers `{movers[character]}` already: "
                f"take another sign for `{sign}`"
            )
        if character in glyphs:
            raise ValueError(
                f"`{character}` is a glyph of the game already, of `{glyphs[character].kind}`: "
                f"take another sign for `{sign}`"
            )
    look_signs = tuple(signs.values())
    for character, glyph in glyphs.items():
        signs[character] = _glyph_sign(game, glyph, look_signs)
    return Signs(game, signs, arrows, movers)


def _read_look(game: ir.Game, character: str, text: str) -> Sign:
    """Returns the sign that a look of the author defines. Raises ValueError."""
    if len(character) != 1 or character.isspace():
        raise ValueError(f"a sign is one character, not {character!r}")
    name, *pairs = text.split() or [""]
    kinds = {kind.name: kind for kind in game.kinds}
    if name not in kinds:
        raise ValueError(
            f"look `{character}`: the game has no kind `{name}`{meant(name, list(kinds))}"
        )
    fields = {field.name: field for field in kinds[name].fields}
    values = {}
    for pair in pairs:
        field_name, equals, text = pair.partition("=")
        if field_name not in fields or not equals:
            reason = f"`{name}` has no fields"
            if fields:
                reason = f"`{name}` has no field `{field_name}`{meant(field_name, fields)}"
            raise ValueError(f'look `{character}`: write "{name} field=value"; {reason}')
        type_ = fields[field_name].type
        if type_.indexed_by or type_.kind == "agents":
            raise ValueError(
                f"look `{character}`: `{name}.{field_name}` has many values; put it with `fields`"
            )
        value = _read_value(text, type_)
        values[field_name] = from_author(f"{name}.{field_name}", value, type_, game.agents.number)
    if not values:
        raise ValueError(
            f'look `{character}`: say which state it stands for, as "{name} field=value"'
        )
    return Sign(character, name, values)


def _read_value(text: str, type_: ir.Type) -> Any:
    """Returns a value written in a look.

    A text that should be a number and isn't one is returned unchanged; `held` refuses it.
    """
    if type_.kind == "word":
        return text
    if text == "nobody" and type_.kind == "agent":
        return None
    try:
        return int(text) if type_.kind != "real" else float(text)
    except ValueError:
        return text


def _glyph_sign(game: ir.Game, glyph: ir.GlyphMeaning, looks: Iterable[Sign]) -> Sign:
    """Returns a glyph of the map as a sign.

    With values of all fields by which signs of its kind differ.
    """
    kind = kind_named(game, glyph.kind)
    names: set[str] = set()
    for other in game.glyphs:
        if other.kind == kind.name:
            names.update(name for name, _ in other.starts)
    for look in looks:
        if look.kind == kind.name:
            names.update(look.values)
    values = {field.name: _start(field) for field in kind.fields if field.name in names}
    return Sign(glyph.glyph, kind.name, {**values, **dict(glyph.starts)})


def _start(declared: ir.VarField) -> Any:
    """Returns the declared start of a field with one value."""
    if declared.type.kind in ("int", "real") and declared.start is None:
        return 0
    return declared.start
