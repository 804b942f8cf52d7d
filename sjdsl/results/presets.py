"""Which preset a run has the settings of."""

import json
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from sjdsl.trainers.config import KEYS_OF, ConfigError
from sjdsl.trainers.preset import load_preset

# What is asked for besides a preset and leaves its name: how agents are rewarded.
ASKED = ("algorithm", "reward", "sharing", "exchange_ratio", "svo_weight", "svo_angle")


def preset_of(game: str, settings: Mapping[str, Any]) -> str:
    """Returns the preset of this package with whose settings a run was trained, but for its reward; `""` where there is none.

    Where presets have the same settings for a game, all of them: `overnight/two_cores`.

    Args:
      settings: of its configuration, as JSON has them, without what does not change what is learnt.
    """
    if settings["algorithm"] not in KEYS_OF or Path(str(settings["reward"])).suffix:  # one's own are files, which are not run here
        return ""
    presets = _presets(game, json.dumps({name: settings[name] for name in ASKED if name in settings}))
    return "/".join(name for name, like in presets.items() if all(like.get(key) == value for key, value in settings.items()))


@cache
def _presets(game: str, asked: str) -> Mapping[str, Mapping[str, Any]]:
    """Returns the configuration of each preset that can be asked for so, by its name."""
    found = {}
    for name in sorted(entry.name.removesuffix(".toml") for entry in files("sjdsl.trainers").joinpath("presets").iterdir()):
        try:
            found[name] = load_preset(name, json.loads(asked), game, asked=()).config.model_dump(mode="json")
        except ConfigError:
            continue
    return found
