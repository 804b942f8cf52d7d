"""Which preset a run has the settings of."""

import json
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from sjdsl.trainers.settings.config import KEYS_OF, ConfigError
from sjdsl.trainers.settings.preset import load_preset

# Settings that may be changed without losing the name of the preset: how agents are rewarded.
FREE = ("algorithm", "reward", "sharing", "exchange_ratio", "svo_weight", "svo_angle")


def preset_of(game: str, settings: Mapping[str, Any]) -> str:
    """Returns the preset of this package that has the settings of a run, apart from the reward;
    `""` if there is none.

    If several presets have the same settings for a game, all are named: `overnight/two_cores`.

    Args:
      settings: the settings that affect learning, as JSON values.
    """
    is_users_reward = bool(Path(str(settings["reward"])).suffix)
    if settings["algorithm"] not in KEYS_OF or is_users_reward:  # files, which are not run here
        return ""
    free = json.dumps({name: settings[name] for name in FREE if name in settings})
    return "/".join(
        name
        for name, config in _preset_configs(game, free).items()
        if all(config.get(key) == value for key, value in settings.items())
    )


@cache
def _preset_configs(game: str, changes: str) -> Mapping[str, Mapping[str, Any]]:
    """Returns the configurations of all presets that accept the changes, by name.

    Args:
      changes: settings as JSON, because `cache` hashes its arguments.
    """
    folder = files("sjdsl.trainers.settings").joinpath("presets")
    names = sorted(entry.name.removesuffix(".toml") for entry in folder.iterdir())
    configs = {}
    for name in names:
        with suppress(ConfigError):
            preset = load_preset(name, json.loads(changes), game, asked=())
            configs[name] = preset.config.model_dump(mode="json")
    return configs
