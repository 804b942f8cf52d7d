"""What every device computes of its own environments, and what devices exchange: sums and means.

Random draws do not depend on the number of devices, so that results differ by the order of float sums alone.
"""

from collections.abc import Callable
from typing import Any

import jax
import numpy as np
from jax import Array
from jax.sharding import Mesh, PartitionSpec

ENVS = "envs"
ALL = PartitionSpec()  # what every device has
OF_ENVS, SECOND_OF_ENVS = PartitionSpec(ENVS), PartitionSpec(None, ENVS)  # what has environments on its first axis, or its second


def over_devices(function: Callable[..., Any], given: Any, returned: Any) -> Callable[..., Any]:
    """Returns a function that every device computes with its own environments; on one device the function itself.

    Args:
      function: of arrays, or trees of them; what it returns for `ALL` must be the same on all devices.
      given: which part of each argument a device has: `ALL`, `OF_ENVS` or `SECOND_OF_ENVS`.
      returned: the same of its results.
    """
    devices = np.asarray(jax.devices())
    if devices.size == 1:
        return function
    result: Callable[..., Any] = jax.shard_map(function, mesh=Mesh(devices, (ENVS,)), in_specs=given, out_specs=returned, check_vma=False)
    return result


def mean_of_all(tree: Any) -> Any:
    """Returns the means over devices of what each has, inside of `over_devices`; elsewhere what it is given."""
    return jax.lax.pmean(tree, ENVS) if _is_divided() else tree


def sum_of_all(tree: Any) -> Any:
    """Returns the sums over devices of what each has, inside of `over_devices`; elsewhere what it is given."""
    return jax.lax.psum(tree, ENVS) if _is_divided() else tree


def own_keys(key: Array, number: int) -> Array:
    """Returns a key for each of `number` things of this device, such as its environments; those of all devices are split from one key."""
    if not _is_divided():
        return jax.random.split(key, number)
    keys = jax.random.split(key, number * jax.lax.axis_size(ENVS))
    result: Array = jax.lax.dynamic_slice_in_dim(keys, jax.lax.axis_index(ENVS) * number, number)
    return result


def own_share(number: int) -> int:
    """Returns how many of so many things a device has, inside of `over_devices`; elsewhere all."""
    return number // jax.lax.axis_size(ENVS) if _is_divided() else number


def _is_divided() -> bool:
    return ENVS in jax.sharding.get_abstract_mesh().manual_axes
