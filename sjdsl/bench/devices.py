"""Splits environments over the devices of one machine; on a CPU, each core then plays environments
of its own.

As one device, a CPU with several cores splits the work of every kernel. A step of a fast game has
some 200 kernels of a few microseconds each, so the cores spend most of the time waiting for each
other (docs/research/performance.md).
"""

from collections.abc import Callable

import jax
from jax import Array, lax
from jax.sharding import PartitionSpec

AXIS = "devices"


def on_devices(loop: Callable[[Array], Array], devices: int) -> Callable[[Array], Array]:
    """Returns a function of a key that runs the loop on every device and returns the sum of the
    results.

    Each device has a key of its own. Raises ValueError if JAX has fewer devices.
    """
    mesh = jax.make_mesh((devices,), (AXIS,))

    def run_on_device(key: Array) -> Array:
        return loop(jax.random.fold_in(key, lax.axis_index(AXIS)))[None]

    run_on_all = jax.shard_map(
        run_on_device,
        mesh=mesh,
        in_specs=PartitionSpec(),
        out_specs=PartitionSpec(AXIS),
        # Else JAX would refuse the loop: the states that it begins with are constants, the same on
        # all devices, and those after a step aren't.
        check_vma=False,
    )

    def run(key: Array) -> Array:
        result: Array = run_on_all(key).sum()
        return result

    return run
