"""Data-parallel training: shards environments over all devices, and replicates everything else.

PPO plays and learns on each device separately (`data_parallel`). JAX's partitioner divides the
rest, and all of other algorithms: sums over environments become sums over devices.
"""

from dataclasses import replace
from typing import Any

import jax
import numpy as np
from jax.sharding import Mesh, NamedSharding, PartitionSpec

from ..algorithms.training_functions import TrainState
from ..devices.data_parallel import ENVS
from ..settings.config import Config, ConfigError


def make_mesh(config: Config) -> Mesh:
    """Returns all devices of all processes.

    Raises:
      ConfigError: the environments don't divide into the devices.
    """
    devices = jax.devices()
    if config.num_envs % len(devices):
        raise ConfigError(
            f"num_envs = {config.num_envs} environments cannot be spread over {len(devices)} "
            "devices; choose a multiple"
        )
    return Mesh(np.asarray(devices), (ENVS,))


def everywhere(mesh: Mesh) -> NamedSharding:
    """Returns the placement of arrays that all devices have."""
    return NamedSharding(mesh, PartitionSpec())


def placement_of(state: TrainState, mesh: Mesh, seeds: int) -> TrainState:
    """Returns the placement of each leaf of a state; with several seeds, their axis comes first."""
    axes = (ENVS,) if seeds == 1 else (None, ENVS)
    spread = NamedSharding(mesh, PartitionSpec(*axes))
    placed: TrainState = jax.tree.map(lambda _: everywhere(mesh), state)
    return replace(placed, worlds=jax.tree.map(lambda _: spread, state.worlds))


def with_placement(shapes: Any, places: Any) -> Any:
    """Returns shapes and dtypes with their placement."""
    return jax.tree.map(
        lambda leaf, place: jax.ShapeDtypeStruct(leaf.shape, leaf.dtype, sharding=place),
        shapes,
        places,
    )
