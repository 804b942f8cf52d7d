"""Presets: a game and a configuration that are known to work together, as TOML files in this package."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

from .config import Config, ConfigError, nearest_key


@dataclass(frozen=True)
class Preset:
    """What to train, and how."""

    game: str  # first argument of `sjdsl.make`
    environment: Mapping[str, Any]  # its other arguments
    config: Config


def load_preset(name: str, changes: Mapping[str, Any] | None = None) -> Preset:
    """Returns a packaged preset, with `changes` in place of values of its configuration.

    Raises:
      ConfigError: no such preset, or a wrong key or value in `changes`.
    """
    stored = {file.name.removesuffix(".toml"): file for file in (files(__package__) / "presets").iterdir()}
    if name not in stored:
        raise ConfigError(f"unknown preset `{name}`{nearest_key(name, stored)}")
    content = tomllib.loads(stored[name].read_text(encoding="utf-8"))
    config = Config(**{**content["config"], **(changes or {})})
    return Preset(content["game"], content.get("environment", {}), config)
