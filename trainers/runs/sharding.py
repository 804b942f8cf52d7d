"""Data-parallel training: shards environments over all devices, and replicates everything else.

PPO plays and learns on each device separately (`data_parallel`). JAX's partitioner divides the rest, and all of other algorithms: sums over
environments become sums over devices.
"""

from dataclasses import dataclass

import jax
import numpy as np
from jax.sharding import Mesh, NamedSharding, PartitionSpec

from ..algorithms.training_functions import TrainState
from ..devices.data_parallel import ENVS
from ..settings.config import Config, ConfigError


@dataclass(frozen=True)
class Placement:
    """Where the arrays of a run are."""

    mesh: Mesh
    seeds: int  # runs side by side; if there are several, their axis comes first

    @property
    def everywhere(self) -> NamedSharding:
        return NamedSharding(self.mesh, PartitionSpec())

    @property
    def spread(self) -> NamedSharding:
        """Environments, the first axis after seeds, over devices."""
        return NamedSharding(self.mesh, PartitionSpec(*([None] if self.seeds > 1 else []), ENVS))

    def of_state(self, state: TrainState) -> TrainState:
        """Returns the placement of every leaf of a state."""
        placed = jax.tree.map(lambda _: self.everywhere, state)
        result: TrainState = placed.replace(
            worlds=jax.tree.map(lambda _: self.spread, state.worlds)
        )
        return result


def make_placement(config: Config) -> Placement:
    """Returns the placement on all devices of all processes.

    Raises:
      ConfigError: the environments don't divide into the devices.
    """
    devices = jax.devices()
    if config.num_envs % len(devices):
        raise ConfigError(
            f"num_envs = {config.num_envs} environments cannot be spread over {len(devices)} devices; choose a multiple"
        )
    return Placement(Mesh(np.asarray(devices), (ENVS,)), config.seeds)
