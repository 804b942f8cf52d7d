"""Who plays each agent of a game: a person, and policies by their names."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


class CannotPlay(Exception):
    """Somebody can't play the game on the board; the message says what to change."""


@dataclass(frozen=True)
class Seats:
    """Who plays each agent of one game, by the names of `sjdsl play --slots`.

    path: of the game, in the page.
    code: what stored policies and runs may load, as `--allow-code` names it.
    limits: of the calls of one page, arguments of `sjdsl.models.Limits`.
    """

    path: str
    names: tuple[str, ...]
    code: tuple[str, ...] = ()
    limits: Mapping[str, Any] = field(default_factory=dict)
