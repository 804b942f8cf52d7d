"""Reads and checks `games/socialjax.toml`, the table that maps SocialJax's games to ours."""

import tomllib
from functools import cache
from typing import Literal

from pydantic import BaseModel, ConfigDict

from sjdsl.library.games_folder import games_folder

FILE = "socialjax.toml"
Source = str | list[str]  # the channels of ours that add up to one of theirs; "": always zero
NOT_HERE = "not here: "  # the prefix of sources that only SocialJax has
EVERYONE = "everyone."  # the prefix of sources with a channel for each agent


class _Row(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Figure(_Row):
    """One number of the infos: an event or a metric (`of`), or whether an action was chosen.

    `sum`: over all agents.
    """

    of: str | None = None
    action: str | None = None
    sum: bool = False
    times: tuple[str | int, ...] = ()


class Entry(_Row):
    """One id."""

    game: str
    tiles: list[Source] = []
    plain: list[str] = []
    headings: Literal["left first", "right first"] = "left first"
    compass: Literal["turned round", "as ours"] = "turned round"
    rest: list[str] = []
    # Instead of tiles, agents and rest: numbers, each a weighted sum of channels of ours.
    layers: list[dict[str, int]] = []
    # The keyword for the side of the window, and the only value that it may have.
    window: tuple[str, int] = ("obs_size", 11)
    steps: int = 1000  # of an episode
    shared_rewards: bool = True  # by default
    # Which rewards are multiplied by the number of agents: `alone`: those that aren't shaped;
    # `shaped`: those that are, before shaping.
    scaled: tuple[Literal["alone", "shaped"], ...] = ("alone", "shaped")
    shared: Literal["sum", "mean"] = "sum"
    info: dict[str, Figure] = {}
    kwargs: dict[str, str] = {}
    letters: dict[str, str] = {}


@cache
def entries() -> dict[str, Entry]:
    """Returns what the table says of each id of the suite."""
    table = tomllib.loads((games_folder() / FILE).read_text(encoding="utf-8"))
    return {name: Entry.model_validate(row) for name, row in table.items()}


def channels_of(source: Source, num_agents: int) -> list[str]:
    """Returns the channels of ours that a source reads."""
    channels: list[str] = []
    for name in [source] if isinstance(source, str) else source:
        if name.startswith(EVERYONE):
            field = name.removeprefix(EVERYONE)
            channels += [f"everyone[{agent}].{field}" for agent in range(num_agents)]
        elif name and not name.startswith(NOT_HERE):
            channels.append(name)
    return channels
