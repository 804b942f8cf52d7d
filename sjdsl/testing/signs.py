"""The characters of a test's picture: glyphs of the map and of movers, characters of the author's own, arrows for agents."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import kind_named
from sjdsl.near_names import meant
from sjdsl.testing.values import held

UNKNOWN = "?!*%$"  # the first that is no sign is drawn where a cell is in a state without a sign


@dataclass(frozen=True)
class Sign:
    """A kind, and the fields and values a character speaks of (as the interpreter holds them)."""

    character: str
    kind: str
    values: Mapping[str, Any] = field(default_factory=dict)

    def __str__(self) -> str:
        return " ".join([self.kind, *(f"{name}={value}" for name, value in self.values.items())])


@dataclass(frozen=True)
class Signs:
    """All signs of a stage by character, the author's before the glyphs; `arrows`: agents facing north, east, south, west.

    movers: character -> sort of movers.
    """

    game: ir.Game
    by_character: Mapping[str, Sign]
    arrows: str
    movers: Mapping[str, str] = field(default_factory=dict)

    def stands(self, character: str) -> bool:
        """Returns whether an agent or a mover is drawn so; what it stands on is not seen."""
        return character in self.arrows or character in self.movers

    def draw(self, kind: str, here: Mapping[str, Any]) -> str:
        """Returns the sign of a cell: of those that fit, the one that speaks of most fields."""
        fitting = [
            s
            for s in self.by_character.values()
            if s.kind == kind and all(here[n] == v for n, v in s.values.items())
        ]
        if not fitting:
            return next(c for c in UNKNOWN if c not in self.by_character)
        return max(fitting, key=lambda sign: len(sign.values)).character

    def told(self, kind: str) -> set[str]:
        """Returns the fields that some sign of a kind speaks of."""
        return {
            name for sign in self.by_character.values() if sign.kind == kind for name in sign.values
        }

    def meaning(self, character: str, glyph: str) -> dict[str, Any]:
        """Returns the values to give to a cell shown so. What a look does not speak of is as on the map, where `glyph` stands."""
        return {**self.by_character[glyph].values, **self.by_character[character].values}


def make_signs(game: ir.Game, looks: Mapping[str, str], arrows: str) -> Signs:
    """Returns the signs of a game. `looks`: character -> what it stands for, as `"tree fruit=none"`.

    Raises ValueError: a character twice or not usable, a kind, field or value the game does not have.
    """
    if len(set(arrows)) != 4:
        raise ValueError(
            f"`arrows` are four different characters, for north, east, south and west, not {arrows!r}"
        )
    mine = {character: _look(game, character, text) for character, text in looks.items()}
    glyphs = {g.glyph: g for g in game.glyphs}
    movers = {sort.glyph: sort.name for sort in game.movers}
    for character in (*mine, *glyphs, *movers):
        if character in arrows:
            what = f"a `{movers[character]}`" if character in movers else "a cell"
            raise ValueError(
                f"`{character}` is an arrow of an agent and stands for {what}: give the stage other `arrows`, four characters"
            )
    for character, sign in mine.items():
        if character in movers:
            raise ValueError(
                f"`{character}` stands for the movers `{movers[character]}` already: take another sign for `{sign}`"
            )
        if character in glyphs:
            raise ValueError(
                f"`{character}` is a glyph of the game already, of `{glyphs[character].kind}`: take another sign for `{sign}`"
            )
    own = {character: _glyph(game, glyph, mine.values()) for character, glyph in glyphs.items()}
    return Signs(game, mine | own, arrows, movers)


def _look(game: ir.Game, character: str, text: str) -> Sign:
    if len(character) != 1 or character.isspace():
        raise ValueError(f"a sign is one character, not {character!r}")
    name, *pairs = text.split() or [""]
    kind = next((k for k in game.kinds if k.name == name), None)
    if kind is None:
        raise ValueError(
            f"look `{character}`: the game has no kind `{name}`{meant(name, [k.name for k in game.kinds])}"
        )
    values = {}
    for pair in pairs:
        field_name, equals, value = pair.partition("=")
        declared = next((f for f in kind.fields if f.name == field_name), None)
        if declared is None or not equals:
            names = [f.name for f in kind.fields]
            raise ValueError(
                f'look `{character}`: write "{name} field=value"; {f"`{name}` has no field `{field_name}`{meant(field_name, names)}" if names else f"`{name}` has no fields"}'
            )
        if declared.type.by or declared.type.kind == "agents":
            raise ValueError(
                f"look `{character}`: `{name}.{field_name}` has many values; put it with `fields`"
            )
        values[field_name] = held(
            f"{name}.{field_name}", _read(value, declared.type), declared.type, game.agents.number
        )
    if not values:
        raise ValueError(
            f'look `{character}`: say which state it stands for, as "{name} field=value"'
        )
    return Sign(character, name, values)


def _read(text: str, type_: ir.Type) -> Any:
    """Returns a value written in a look; what is no number stays a text and is refused later if one is wanted."""
    if type_.kind == "word":
        return text
    if text == "nobody" and type_.kind == "agent":
        return None
    try:
        return int(text) if type_.kind != "real" else float(text)
    except ValueError:
        return text


def _glyph(game: ir.Game, glyph: ir.GlyphMeaning, looks: Iterable[Sign]) -> Sign:
    """Returns a glyph of the map as a sign: it speaks of all fields by which signs of its kind differ."""
    kind = kind_named(game, glyph.kind)
    told = {name for g in game.glyphs if g.kind == kind.name for name, _ in g.starts}
    told |= {name for look in looks if look.kind == kind.name for name in look.values}
    starts = dict(glyph.starts)
    return Sign(
        glyph.glyph,
        kind.name,
        {f.name: starts.get(f.name, _start(f)) for f in kind.fields if f.name in told},
    )


def _start(declared: ir.VarField) -> Any:
    """Returns the declared start of a field with one value."""
    if declared.type.kind in ("int", "real") and declared.start is None:
        return 0
    return declared.start
