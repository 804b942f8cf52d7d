"""Presets: what to train and how, in one TOML file; some come with this package.

game = "coins"

[environment]       # further arguments of sjdsl.make
num_agents = 2

[config]            # keys of Config
learning_rate = 1e-3
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from .config import Config, ConfigError, nearest_key

SECTIONS = {"game": str, "environment": dict, "config": dict}


@dataclass(frozen=True)
class Preset:
    """What to train, and how."""

    game: str  # first argument of `sjdsl.make`
    environment: Mapping[str, Any]  # its other arguments
    config: Config


def load_preset(name: str | Path, changes: Mapping[str, Any] | None = None) -> Preset:
    """Returns a preset, with `changes` in place of values of its configuration.

    Args:
      name: of a preset in this package, such as `quick`, or the path of a `.toml` file.
      changes: configuration keys and their new values; text such as `"3e-4"` is read as a number.
    Raises:
      ConfigError: no such preset, or a wrong key or value.
    """
    text = _read(name)
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{name}: {error}") from None
    for key, value in content.items():
        if key not in SECTIONS:
            raise ConfigError(f"{name}: unknown key `{key}`{nearest_key(key, SECTIONS)}")
        if not isinstance(value, SECTIONS[key]):
            raise ConfigError(f"{name}: `{key}` must be {'a table' if SECTIONS[key] is dict else 'text'}, not {value!r}")
    if "game" not in content:
        raise ConfigError(f'{name}: no game is named; write `game = "coins"` above the tables')
    config = Config(**{**content.get("config", {}), **(changes or {})})
    return Preset(content["game"], content.get("environment", {}), config)


def _read(name: str | Path) -> str:
    if Path(name).suffix == ".toml":
        if not Path(name).is_file():
            raise ConfigError(f"{name} does not exist")
        return Path(name).read_text(encoding="utf-8")
    packaged = {file.name.removesuffix(".toml"): file for file in (files(__package__) / "presets").iterdir()}
    if name not in packaged:
        raise ConfigError(f"unknown preset `{name}`{nearest_key(str(name), packaged)}")
    return packaged[str(name)].read_text(encoding="utf-8")
