"""How `vmap` computes a layer for many networks on a CPU: one kernel after the other."""

from collections.abc import Callable

import jax
from jax import Array
from jax.custom_batching import custom_vmap

Layer = Callable[[Array, Array], Array]  # (windows [M, ...], kernel) -> [M, ...]


def kernel_by_kernel(layer: Layer) -> Layer:
    """Returns a layer that `vmap` computes for one kernel at a time.

    A batch of kernels would become one operation with another axis, which XLA's CPU compiler lays
    out badly or has no fast form of. A batch of windows alone is just more windows.
    """

    @custom_vmap
    def of_kernel(windows: Array, kernel: Array) -> Array:
        return layer(windows, kernel)

    @of_kernel.def_vmap
    def of_batch(
        size: int, is_batched: list[bool], windows: Array, kernel: Array
    ) -> tuple[Array, bool]:
        windows_batched, kernel_batched = is_batched
        if not kernel_batched:
            together = of_kernel(windows.reshape(-1, *windows.shape[2:]), kernel)
            return together.reshape(size, -1, *together.shape[1:]), True
        if windows_batched:
            return jax.lax.map(lambda both: of_kernel(*both), (windows, kernel)), True
        return jax.lax.map(lambda one: of_kernel(windows, one), kernel), True

    result: Layer = of_kernel
    return result
