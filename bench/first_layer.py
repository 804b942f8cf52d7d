"""Times the first dense layer of a network on 2,000 windows of Commons Harvest: a product, the lookups that CPUs make, and one large lookup."""

import timeit

import jax
import jax.numpy as jnp
from jax import Array

import sjdsl
from sjdsl.runtime.tokens import to_channels
from sjdsl.trainers.window_layer import look_up, look_up_gradient
from sjdsl.trainers.window_rows import groups_of, make_tables, row_numbers

WINDOWS, WIDTH, CALLS = 2000, 64, 41

env = sjdsl.make("harvest_open")
PLANES = env.token_planes
(GROUP,) = groups_of(PLANES, WINDOWS)
CELLS = env.observation_shape[-1] * env.observation_shape[-2]


def channels(windows: Array) -> Array:
    """Returns the input of the layer, `[M, C * V * V]`."""
    return to_channels(windows, PLANES, jnp.dtype(jnp.float32), scale_numbers=True).reshape(len(windows), -1)


def one_lookup(kernel: Array, windows: Array) -> Array:
    """Returns the layer's sums from the same tables, without a loop over cells."""
    tables = make_tables(kernel.reshape(-1, CELLS, 1, WIDTH), GROUP, PLANES)
    rows = row_numbers(windows.reshape(1, len(windows), -1, CELLS), GROUP, PLANES)
    return tables[jnp.arange(CELLS)[:, None], rows].sum(axis=0)


def main() -> None:
    """Prints the median of the calls of each."""
    envs = -(-WINDOWS // env.num_agents)
    seen = jax.vmap(env.reset)(jax.random.split(jax.random.key(0), envs))[0]
    windows = seen.reshape(-1, *env.observation_shape[-3:])[:WINDOWS]
    kernel, gradient = jnp.ones((channels(windows[:1]).shape[1], WIDTH)), jnp.ones((WINDOWS, WIDTH))
    forward = {"product": lambda kernel, windows: channels(windows) @ kernel, "one lookup": one_lookup}
    forward["lookups"] = lambda kernel, windows: look_up(kernel, windows, PLANES)
    backward = {"product": lambda windows, gradient: gradient.T @ channels(windows)}
    backward["lookups"] = lambda windows, gradient: look_up_gradient(windows, gradient, PLANES)
    for title, functions, inputs in (("forward", forward, (kernel, windows)), ("gradient", backward, (windows, gradient))):
        for name, function in functions.items():
            call = jax.jit(function)
            jax.block_until_ready(call(*inputs))
            seconds = timeit.repeat(lambda call=call, inputs=inputs: jax.block_until_ready(call(*inputs)), number=1, repeat=CALLS)
            print(f"{title}, {name}: {1e3 * sorted(seconds)[CALLS // 2]:.1f} ms")


if __name__ == "__main__":
    main()
