"""What the names of a game stand for in its text: parameters by their values, and nouns."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.queries import all_fields
from sjdsl.doc.wording import joined

SHORTEST = 3  # letters of a variable's name that can stand for a noun, such as `zapper`


@dataclass(frozen=True)
class Naming:
    """A game and its parameters.

    values: of each parameter: a number, a word, or nested tuples of them.
    terms: the defines that the text explains once, so that elsewhere their names are enough.
    """

    game: ir.Game
    values: Mapping[str, Any]
    terms: frozenset[str] = field(default=frozenset())

    @cached_property
    def all_kinds(self) -> frozenset[str]:
        """The kinds of cell that are on the map."""
        glyphs = set().union(*self.game.rows)
        return frozenset(glyph.kind for glyph in self.game.glyphs if glyph.glyph in glyphs)

    def is_ambiguous(self, shape: str) -> bool:
        """Returns whether an action or a field has the name of a shape as well."""
        names = {field.name for field in all_fields(self.game)}
        return shape in names | set(self.game.agents.actions)

    @property
    def somebody(self) -> str:
        """Who occupies cells: `agent`, or `agent or deer`."""
        return joined(("agent", *(movers.name for movers in self.game.movers)), "or")

    def kinds(self, kinds: tuple[str, ...]) -> str:
        """Returns `soil cell`, `soil or sand cell`, or `cell` of any kind."""
        if len(kinds) > 1 and self.all_kinds <= set(kinds):
            return "cell"
        others = sorted(self.all_kinds - set(kinds))
        if len(kinds) > 2 and len(others) < len(kinds):
            return f"cell other than {joined(others, 'or')}"
        return f"{joined(kinds, 'or')} cell"

    def noun(self, member: ir.Member, plural: bool = False) -> str:
        """Returns `agent`, `deer` or `soil cell`."""
        if member.entity_type.what == "cell":
            noun = self.kinds(member.kinds)
            return noun.replace("cell", "cells", 1) if plural else noun
        return (
            "agents" if plural and member.entity_type.what == "agent" else member.entity_type.name
        )

    def is_plain(self, member: ir.Member) -> bool:
        """Returns whether a variable is called as what it is."""
        if member.entity_type.what == "cell":
            return member.kinds == (member.name,)
        return member.name == member.entity_type.name

    def introduced(self, member: ir.Member, plural: bool = False) -> str:
        """Returns a variable where it is introduced: `soil cell`, `agent (the zapper)`."""
        noun = self.noun(member, plural)
        if self.is_plain(member):
            return noun
        if len(member.name) < SHORTEST:
            return f"{noun} {member.name}"
        return f"{noun} ({'each ' if plural else 'the '}{member.name})"

    def refer(self, member: ir.Member) -> str:
        """Returns a variable where it is used: `the soil`, `the zapper`, `agent a`, `cell x`."""
        if len(member.name) < SHORTEST and not self.is_plain(member):
            return f"{'cell' if member.entity_type.what == 'cell' else member.entity_type.name} {member.name}"
        return f"the {member.name}"


def article(noun: str) -> str:
    """Returns `a wall cell`, `an ore cell`."""
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"
