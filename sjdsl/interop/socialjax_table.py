"""How the released suite's games are told from ours: `games/socialjax.toml`, checked."""

import tomllib
from functools import cache
from typing import Literal

from pydantic import BaseModel, ConfigDict

from sjdsl.games_folder import games_folder

FILE = "socialjax.toml"
Source = str | list[str]  # the channels of ours that make one of theirs; "": always zero


class _Row(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Figure(_Row):
    """One number of the infos: an event or a metric (`of`), or whether an action was chosen; `sum`: over all agents."""

    of: str | None = None
    action: str | None = None
    sum: bool = False
    times: tuple[str, ...] = ()


class Entry(_Row):
    """One id."""

    game: str
    tiles: list[Source]
    headings: Literal["left first", "right first"]
    compass: Literal["turned round", "as ours"] = "turned round"
    rest: list[str]
    info: dict[str, Figure]
    kwargs: dict[str, str] = {}
    letters: dict[str, str] = {}


@cache
def entries() -> dict[str, Entry]:
    """Returns the ids."""
    table = tomllib.loads((games_folder() / FILE).read_text(encoding="utf-8"))
    return {name: Entry.model_validate(row) for name, row in table.items()}
