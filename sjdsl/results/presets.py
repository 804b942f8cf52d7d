"""Which preset a run has the settings of."""

import json
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from sjdsl.trainers.settings.config import KEYS_OF, ConfigError
from sjdsl.trainers.settings.preset import load_preset

# Settings that may be changed without losing the name of the preset: how agents are rewarded.
ASKED = ("algorithm", "reward", "sharing", "exchange_ratio", "svo_weight", "svo_angle")


def preset_of(game: str, settings: Mapping[str, Any]) -> str:
    """Returns the preset of this package that has the settings of a run, apart from the reward;
    `""` if there is none.

    If several presets have the same settings for a game, all are named: `overnight/two_cores`.

    Args:
      settings: the settings that affect learning, as JSON values.
    """
    if (
        settings["algorithm"] not in KEYS_OF or Path(str(settings["reward"])).suffix
    ):  # custom ones are files, which are not run here
        return ""
    presets = _presets(
        game, json.dumps({name: settings[name] for name in ASKED if name in settings})
    )
    return "/".join(
        name
        for name, like in presets.items()
        if all(like.get(key) == value for key, value in settings.items())
    )


@cache
def _presets(game: str, asked: str) -> Mapping[str, Mapping[str, Any]]:
    """Returns the configurations of all presets that accept the settings `asked`, by name."""
    found = {}
    for name in sorted(
        entry.name.removesuffix(".toml")
        for entry in files("sjdsl.trainers.settings").joinpath("presets").iterdir()
    ):
        try:
            found[name] = load_preset(name, json.loads(asked), game, asked=()).config.model_dump(
                mode="json"
            )
        except ConfigError:
            continue
    return found
