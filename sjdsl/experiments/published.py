"""What has been published of a game, to be shown beside what is found here: `games/published.toml`."""

import tomllib
from collections.abc import Mapping
from typing import Any

from sjdsl.experiments.bundled_rules import is_bundled
from sjdsl.games_folder import games_folder

FILE = "published.toml"


def published_shape(game: str) -> dict[str, Any] | None:
    """Returns `shape`, `type`, `note` and `source` of the published Schelling diagram of a game; None if there is none."""
    table = tomllib.loads((games_folder() / FILE).read_text(encoding="utf-8"))["schelling"]
    entry = table["games"].get(game)
    return None if entry is None else {**entry, "source": table["source"]}


def published_beside(described: Mapping[str, Any]) -> dict[str, Any] | None:
    """Returns the same of the game that was played; None, too, where it is not the bundled game as it is now.

    Args:
      described: `name`, `hash` and `params` of the game as a manifest has them.
    """
    published = published_shape(described["name"])
    return published if published is not None and is_bundled(described) else None
