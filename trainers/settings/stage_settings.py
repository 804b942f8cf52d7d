"""What the stages of a run have in common, so that each can continue from the policy before it."""

from collections.abc import Sequence
from itertools import pairwise

from .config import Config
from .config_errors import ConfigError

STAGES = "stages"  # the key of a preset, and the folder of a run with all its stages but the last

# Two runs must share these for one to start with the parameters of the other.
SHAPING_NETWORKS = (
    "algorithm",
    "own",
    "network",
    "network_width",
    "convolution_sides",
    "convolution_channels",
    "layer_norm",
    "share_hidden",
    "agent_id",
    "sharing",
    "critic",
    "reward_horizons",
    "memory",
    "memory_reads",
    "partners",
)
# These may change from stage to stage as long as the networks keep their shapes.
MAY_CHANGE = {"own", "partners"}


def check_settings(configs: Sequence[Config], place: str = STAGES) -> None:
    """Checks that the configurations of stages agree in what can't change from one to the next.

    Args:
      place: of the stages, for the message.
    Raises:
      ConfigError: they don't, or a later stage starts from another policy.
    """
    kept = ["seed", "seeds", *(name for name in SHAPING_NETWORKS if name not in MAY_CHANGE)]
    for number, (before, config) in enumerate(pairwise(configs), 2):
        for name in kept:
            old = getattr(before, name, None)
            new = getattr(config, name, None)
            if old != new:
                raise ConfigError(
                    f"{place}[{number}]: `{name}` can't change from stage to stage: "
                    f"it is {old} before, and {new} here"
                )
        if config.init_from:
            raise ConfigError(
                f"{place}[{number}]: leave `init_from` out: "
                "a stage starts from the policy of the one before"
            )
