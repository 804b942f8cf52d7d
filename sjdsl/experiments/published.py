"""What has been published of a game, to be shown beside what is found here: `games/published.toml`."""

import tomllib
from typing import Any

from sjdsl.games_folder import games_folder

FILE = "published.toml"


def published_shape(game: str) -> dict[str, Any] | None:
    """Returns `shape`, `type`, `note` and `source` of the published Schelling diagram of a game; None if there is none."""
    table = tomllib.loads((games_folder() / FILE).read_text(encoding="utf-8"))["schelling"]
    entry = table["games"].get(game)
    return None if entry is None else {**entry, "source": table["source"]}
