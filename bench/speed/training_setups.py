"""What training is measured of: environments by network, algorithm and sharing of parameters, each with its configuration."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any, cast

from bench.speed.training_split import Algorithm, Network, Sharing
from sjdsl.trainers.config import Config, ConfigError, VDNConfig, make_config

if TYPE_CHECKING:
    from sjdsl.runtime.env import Environment

UPDATES = 1000  # of the run whose update is measured: schedules of learning rates and of exploration need a length
ROLLOUT = {"ippo": (16, 128), "mappo": (16, 128)}  # environments and steps unless others are asked for; of vdn those of its configuration


@dataclass(frozen=True)
class Setup:
    """An environment and the configuration that it is trained with."""

    name: str  # of the game, with its variant: `game+variant`
    env: "Environment"
    config: Config

    @property
    def network(self) -> Network:
        return cast("Network", self.config.network)

    @property
    def learning(self) -> tuple[Algorithm, Sharing]:
        """The algorithm, and which agents have one network: of vdn all have."""
        return cast("Algorithm", self.config.algorithm), getattr(self.config, "sharing", "shared")

    def __str__(self) -> str:
        return ", ".join((self.name, self.network, *self.learning))


def training_setups(
    envs: Sequence[tuple[str, "Environment"]],
    networks: Sequence[Network],
    algorithms: Sequence[Algorithm] = ("ippo",),
    sharings: Sequence[Sharing] = ("shared",),
    num_envs: int | None = None,
    num_steps: int | None = None,
) -> tuple[tuple[Setup, ...], tuple[str, ...]]:
    """Returns what can be measured, and a line for each that its game or its sizes refuse.

    Args:
      envs: environments with tokens, each behind what it is called; numbers of agents of one game are called alike.
      networks, algorithms, sharings: all combinations; vdn has one network for all agents, and is left out where `shared` is not asked for.
      num_envs, num_steps: of a rollout; None: 16 environments for 128 steps, of vdn what its configuration has.
    """
    from sjdsl.trainers import make_train

    setups, refused = [], []
    for (name, env), network, (algorithm, sharing) in product(envs, networks, _learners(algorithms, sharings)):
        try:
            setup = Setup(name, env, _config(network, algorithm, sharing, num_envs, num_steps))
            make_train(env, setup.config)
        except ConfigError as error:
            refused.append(f"{name}, {network}, {algorithm}, {sharing}: {error}")
        else:
            setups.append(setup)
    return tuple(setups), tuple(refused)


def _learners(algorithms: Sequence[Algorithm], sharings: Sequence[Sharing]) -> Iterator[tuple[Algorithm, Sharing]]:
    return ((algorithm, sharing) for algorithm, sharing in product(algorithms, sharings) if algorithm != "vdn" or sharing == "shared")


def _config(network: Network, algorithm: Algorithm, sharing: Sharing, num_envs: int | None, num_steps: int | None) -> Config:
    values: dict[str, Any] = {"algorithm": algorithm, "network": network}
    own = ROLLOUT.get(algorithm, (VDNConfig.model_fields["num_envs"].default, VDNConfig.model_fields["num_steps"].default))
    values |= {"num_envs": num_envs or own[0], "num_steps": num_steps or own[1]}
    steps = values["num_envs"] * values["num_steps"]
    if algorithm == "vdn":
        values["buffer_size"] = math.ceil(VDNConfig.model_fields["buffer_size"].default / steps) * steps
    else:
        values["sharing"] = sharing
    return make_config(values, total_timesteps=steps * UPDATES)
