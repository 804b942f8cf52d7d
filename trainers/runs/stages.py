"""Stages of a run: each has its own environment and settings, and continues from the policy of the one before."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from ..settings.config import Config
from ..settings.config_errors import ConfigError

STAGES = "stages"  # in the folder of a run: the folders of all its stages but the last, which is the run itself
FROM_STAGES = " from stages"

# Settings that two runs must share for one to start with the parameters of the other.
SHAPING_NETWORKS = (
    "algorithm",
    "own",
    "network",
    "network_width",
    "convolution_sides",
    "convolution_channels",
    "layer_norm",
    "agent_id",
    "sharing",
    "critic",
    "memory",
    "partners",
)
MAY_CHANGE = (
    "own",
    "partners",
)  # of these, what may change as long as the networks keep their shapes
KEPT = ("seed", "seeds", *(name for name in SHAPING_NETWORKS if name not in MAY_CHANGE))


def check_settings(configs: Sequence[Config], place: str = STAGES) -> None:
    """Checks that the configurations of stages agree in what can't change from one to the next.

    Args:
      place: of the stages, for the message.
    Raises:
      ConfigError: they don't, or a later stage starts from another policy.
    """
    for number, (before, config) in enumerate(pairwise(configs), 2):
        for name in KEPT:
            old, new = getattr(before, name, None), getattr(config, name, None)
            if old != new:
                raise ConfigError(
                    f"{place}[{number}]: `{name}` can't change from stage to stage: it is {old} before, and {new} here"
                )
        if config.init_from:
            raise ConfigError(
                f"{place}[{number}]: leave `init_from` out: a stage starts from the policy of the one before"
            )


def reward_label(reward: str, from_stages: bool) -> str:
    """Returns the reward of a run in a table: after stages, it isn't the same as from scratch."""
    return f"{reward}{FROM_STAGES}" if from_stages else reward


def stage_folders(folder: Path) -> list[Path]:
    """Returns the folders of all stages of a run, or of one of its seeds, in order; `folder` is that of the last."""
    of_seed = folder.name.startswith("seed_") and not (folder / STAGES).is_dir()
    run_dir = folder.parent if of_seed else folder
    numbered = sorted(
        (path for path in (run_dir / STAGES).glob("*") if path.name.isdecimal()),
        key=lambda path: int(path.name),
    )
    return [*(path / folder.relative_to(run_dir) for path in numbered), folder]
