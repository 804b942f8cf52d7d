"""Reads `games/meltingpot.toml`, the table of Melting Pot's substrates: which bundled game and variant each of them is here."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from sjdsl.library.games_folder import games_folder
from sjdsl.near_names import meant

FILE = "meltingpot.toml"
KEYS = {"game", "variant", "roles", "observations"}


@dataclass(frozen=True)
class Substrate:
    """A substrate of Melting Pot 2.

    Attributes:
      name: Melting Pot's.
      game: the bundled game it is; empty if it has not been written.
      variant: of that game; empty for the game as it is.
      roles: the players' roles there, in the order of our agents; empty where all are `default`.
      observations: what a player observes there beside its picture, by its name there, and what it is made of here: a rule of
        `sjdsl.interop.melting_pot_observations`.
    """

    name: str
    game: str = ""
    variant: str = ""
    roles: tuple[str, ...] = ()
    observations: Mapping[str, Mapping[str, Any]] = field(default_factory=dict, hash=False)


@cache
def substrates() -> dict[str, Substrate]:
    """Returns all substrates by name, those that have not been written among them. Raises ValueError for a key that means nothing."""
    table = tomllib.loads((games_folder() / FILE).read_text(encoding="utf-8"))
    return {name: _substrate(name, entry) for name, entry in table.items()}


def _substrate(name: str, entry: dict[str, Any]) -> Substrate:
    for key in entry.keys() - KEYS:
        raise ValueError(f"{FILE}: `{name}` has no key `{key}`{meant(key, sorted(KEYS))}")
    roles = tuple(role for role, number in entry.get("roles", {}).items() for _ in range(number))
    return Substrate(
        name, entry.get("game", ""), entry.get("variant", ""), roles, entry.get("observations", {})
    )


def written_substrates() -> list[Substrate]:
    """Returns the substrates that have been written."""
    return [substrate for substrate in substrates().values() if substrate.game]
