"""Times the first dense layer of networks: of an agent in Commons Harvest, and of a critic that sees all windows of Clean Up."""

import timeit
from collections.abc import Callable, Iterator
from typing import Any
from unittest.mock import patch

import jax
import jax.numpy as jnp
from jax import Array

import sjdsl
from sjdsl.runtime.env import Environment
from sjdsl.runtime.tokens import to_channels
from sjdsl.trainers import window_rows
from sjdsl.trainers.window_layer import look_up, look_up_gradient
from sjdsl.trainers.window_rows import Planes

WIDTH, CALLS = 64, 41


def steps_of(env: Environment, steps: int) -> Array:
    """Returns initial observations of environments, `[M, N, P, V, V]`."""
    observations: Array = jax.vmap(env.reset)(jax.random.split(jax.random.key(0), steps))[0]
    return observations


def channels(windows: Array, planes: Planes) -> Array:
    """Returns the input of the layer, `[M, C * V * V]`."""
    return to_channels(windows, planes, jnp.dtype(jnp.float32), scale_numbers=True).reshape(len(windows), -1)


def look_up_at_once(kernel: Array, windows: Array, planes: Planes) -> Array:
    """Returns the layer's sums from the same tables, without a loop over cells; of planes that make one group."""
    (group,), cells = window_rows.groups_of(planes, len(windows)), windows.shape[-1] * windows.shape[-2]
    tables = window_rows.make_tables(kernel.reshape(-1, cells, 1, WIDTH), group, planes)
    rows = window_rows.row_numbers(windows.reshape(1, len(windows), -1, cells), group, planes)
    return tables[jnp.arange(cells)[:, None], rows].sum(axis=0)


def cases(windows: Array, planes: Planes) -> Iterator[tuple[str, str, Callable[..., Any], tuple[Array, ...]]]:
    """Yields what is made (the layer's sums or its gradient), the way it is made, the function, and what that takes."""
    kernel, gradient = jnp.ones((channels(windows[:1], planes).shape[1], WIDTH)), jnp.ones((len(windows), WIDTH))
    yield "forward", "product", lambda kernel, windows: channels(windows, planes) @ kernel, (kernel, windows)
    yield "forward", "lookups", lambda kernel, windows: look_up(kernel, windows, planes), (kernel, windows)
    if len(window_rows.groups_of(planes, len(windows))) == 1:
        yield "forward", "one lookup", lambda kernel, windows: look_up_at_once(kernel, windows, planes), (kernel, windows)
    yield "gradient", "product", lambda windows, gradient: gradient.T @ channels(windows, planes), (windows, gradient)
    yield "gradient", "lookups", lambda windows, gradient: look_up_gradient(windows, gradient, planes), (windows, gradient)


def time_layer(title: str, windows: Array, planes: Planes, ways: tuple[str, ...] = ("product", "lookups", "one lookup")) -> None:
    """Prints the median of the calls of each of the ways named."""
    for name, way, function, inputs in cases(windows, planes):
        if way not in ways:
            continue
        call = jax.jit(function)
        jax.block_until_ready(call(*inputs))
        seconds = timeit.repeat(lambda call=call, inputs=inputs: jax.block_until_ready(call(*inputs)), number=1, repeat=CALLS)
        print(f"{title}, {name}, {way}: {1e3 * sorted(seconds)[CALLS // 2]:.1f} ms")


def main() -> None:
    """Times 2,000 windows of one agent each, and 1,000 steps that a central critic reads, with two choices of tables."""
    harvest, clean_up = sjdsl.make("harvest_open"), sjdsl.make("clean_up")
    one_agent = steps_of(harvest, -(-2000 // harvest.num_agents))
    time_layer("2,000 windows", one_agent.reshape(-1, *one_agent.shape[2:])[:2000], harvest.token_planes)
    joint = steps_of(clean_up, 1000)
    joint = joint.reshape(len(joint), -1, *joint.shape[-2:])
    planes = clean_up.token_planes * clean_up.num_agents
    time_layer("central critic", joint, planes)
    with patch.object(window_rows, "LIMITS", window_rows.LIMITS[-1:]):
        time_layer("central critic, largest tables", joint, planes, ("lookups",))


if __name__ == "__main__":
    main()
