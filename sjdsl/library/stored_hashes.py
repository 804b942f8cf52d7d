"""Hashes of bundled games in files of earlier versions: `games/hashes.toml` says what they are now."""

import tomllib
from collections.abc import Mapping
from functools import cache

from sjdsl.library.games_folder import games_folder

FILE = "hashes.toml"


def current_hash(stored: str) -> str:
    """Returns the hash that rules have now whose hash was `stored`; that itself where it isn't one of an earlier version."""
    return _renewed().get(stored, stored)


@cache
def _renewed() -> Mapping[str, str]:
    forms = tomllib.loads((games_folder() / FILE).read_text("utf-8"))
    return {old: new for renewed in forms.values() for old, new in renewed.items()}
