"""What each device computes for its own environments, and what devices exchange: sums and means.

Random draws don't depend on the number of devices, so results differ only by the order of float
sums.
"""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.sharding import Mesh, PartitionSpec

ENVS = "envs"
ALL = PartitionSpec()  # the same on every device
OF_ENVS = PartitionSpec(ENVS)  # what has environments on its first axis
SECOND_OF_ENVS = PartitionSpec(None, ENVS)  # on its second axis


def over_devices(function: Callable[..., Any], in_specs: Any, out_specs: Any) -> Callable[..., Any]:
    """Returns a function that each device computes for its own environments.

    On one device, it is the function itself.

    Args:
      function: of arrays, or trees of them; results marked `ALL` must be the same on all devices.
      in_specs: the part of each argument that a device gets: `ALL`, `OF_ENVS` or `SECOND_OF_ENVS`.
      out_specs: the same for its results.
    """
    devices = np.asarray(jax.devices())
    if devices.size == 1:
        return function
    result: Callable[..., Any] = jax.shard_map(
        function,
        mesh=Mesh(devices, (ENVS,)),
        in_specs=in_specs,
        out_specs=out_specs,
        check_vma=False,
    )
    return result


def mean_of_all(tree: Any) -> Any:
    """Returns the means over devices inside `over_devices`, elsewhere its argument."""
    return jax.lax.pmean(tree, ENVS) if _is_divided() else tree


def sum_of_all(tree: Any) -> Any:
    """Returns the sums over devices inside `over_devices`, elsewhere its argument."""
    return jax.lax.psum(tree, ENVS) if _is_divided() else tree


def own_keys(key: Array, number: int) -> Array:
    """Returns a key for each of `number` items on this device, such as environments.

    The keys of all devices come from one key.
    """
    if not _is_divided():
        return jax.random.split(key, number)
    keys = jax.random.split(key, number * jax.lax.axis_size(ENVS))
    return keys[own_numbers(number)]


def own_numbers(number: int) -> Array:
    """Returns which of all devices' items, counted from 0, are the `number` items on this device.

    `[number]` int32.
    """
    first = jax.lax.axis_index(ENVS) * number if _is_divided() else 0
    return first + jnp.arange(number)


def own_share(number: int) -> int:
    """Returns a device's share of a number of items inside `over_devices`, elsewhere the number."""
    return number // jax.lax.axis_size(ENVS) if _is_divided() else number


def _is_divided() -> bool:
    return ENVS in jax.sharding.get_abstract_mesh().manual_axes
