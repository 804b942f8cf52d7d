"""Reads `games/meltingpot.toml`: which game and variant each of Melting Pot's substrates is."""

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
      name: in Melting Pot.
      game: the bundled game, "" if it hasn't been written.
      variant: of that game, "" for none.
      roles: of Melting Pot's players, in the order of our agents; none if all are `default`.
      observations: Melting Pot's name of an observation other than the picture -> a rule of
        `sjdsl.interop.melting_pot_observations` that computes it.
    """

    name: str
    game: str = ""
    variant: str = ""
    roles: tuple[str, ...] = ()
    observations: Mapping[str, Mapping[str, Any]] = field(default_factory=dict, hash=False)


@cache
def substrates() -> dict[str, Substrate]:
    """Returns all substrates by name, also those that haven't been written.

    Raises:
      ValueError: the table has an unknown key.
    """
    table = tomllib.loads((games_folder() / FILE).read_text(encoding="utf-8"))
    return {name: _substrate(name, entry) for name, entry in table.items()}


def _substrate(name: str, entry: dict[str, Any]) -> Substrate:
    """Returns an entry of `games/meltingpot.toml`. Raises ValueError for an unknown key."""
    for key in entry.keys() - KEYS:
        raise ValueError(f"{FILE}: `{name}` has no key `{key}`{meant(key, sorted(KEYS))}")
    roles = tuple(role for role, number in entry.get("roles", {}).items() for _ in range(number))
    return Substrate(
        name=name,
        game=entry.get("game", ""),
        variant=entry.get("variant", ""),
        roles=roles,
        observations=entry.get("observations", {}),
    )


def written_substrates() -> list[Substrate]:
    """Returns the substrates that have been written."""
    return [substrate for substrate in substrates().values() if substrate.game]
