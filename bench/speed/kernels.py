"""GPU cost of a step: kernels launched, bytes moved, and the share of the copy bandwidth
reached.
"""

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp

from bench.gpu_cost import count_kernels
from sjdsl.bench.loop import Task
from sjdsl.bench.machine import describe_machine
from sjdsl.bench.timing import median_seconds

# float32 numbers that are copied: far more than the caches hold (256 MiB, 1 GiB).
COPIED = {"cpu": 1 << 26, "gpu": 1 << 28}


@dataclass(frozen=True)
class StepKernels:
    """One compiled step of `num_envs` environments."""

    name: str
    num_agents: int
    observation: str
    num_envs: int
    kernels: int  # launched; the body of a loop counts once
    # Bytes for one environment. `accessed`: read and written by the kernels, as XLA counts them;
    # NaN if it doesn't. `least`: the state and the actions read once, the next state, the rewards
    # and the observations written once; no step can move less.
    accessed_bytes: float
    least_bytes: float
    seconds: tuple[float, ...]  # of one step of all environments, by round


@dataclass(frozen=True)
class Kernels:
    """All steps measured, and the speed of a large copy on the same device."""

    machine: dict[str, Any]
    copied_bytes_per_s: float  # read plus written
    steps: tuple[StepKernels, ...]


def measure_kernels(
    tasks: Sequence[Task], num_envs: int, repeats: int = 5, steps: int = 20
) -> Kernels:
    """Returns the cost of one step of each task; `steps` of them are timed together in a round."""
    measured = tuple(_measure_step(task, num_envs, repeats, steps) for task in tasks)
    return Kernels(describe_machine(), copied_bytes_per_s(repeats), measured)


def _measure_step(task: Task, num_envs: int, repeats: int, steps: int) -> StepKernels:
    """Returns the cost of one step; `steps` of them are timed together in a round."""
    states = jax.tree.map(lambda x: jnp.broadcast_to(x, (num_envs, *x.shape)), task.reset())
    keys = jax.random.split(jax.random.key(0), num_envs)
    actions = jax.random.randint(
        jax.random.key(1), (num_envs, task.num_agents), 0, task.num_actions
    )
    compiled = jax.jit(jax.vmap(task.step)).lower(states, actions, keys).compile()
    results = jax.block_until_ready(compiled(states, actions, keys))
    seconds = []
    for _ in range(repeats):
        start = time.perf_counter()
        for _ in range(steps):
            next_states, *_ = results
            results = compiled(next_states, actions, keys)
        jax.block_until_ready(results)
        seconds.append((time.perf_counter() - start) / steps)
    costs = compiled.cost_analysis() or {}
    return StepKernels(
        name=task.name,
        num_agents=task.num_agents,
        observation=task.observation,
        num_envs=num_envs,
        kernels=count_kernels(compiled.as_text() or ""),
        accessed_bytes=float(costs.get("bytes accessed", math.nan)) / num_envs,
        least_bytes=(_bytes_of((states, actions)) + _bytes_of(results)) / num_envs,
        seconds=tuple(seconds),
    )


def copied_bytes_per_s(repeats: int, numbers: int | None = None) -> float:
    """Returns the bytes a second, read and written, of a kernel that adds one to many float32
    numbers: the median of the rounds."""
    size = numbers or COPIED.get(jax.devices()[0].platform, COPIED["cpu"])
    copy = jax.jit(lambda x: x + 1)
    array = jnp.zeros(size, jnp.float32)
    return 2 * array.nbytes / median_seconds(lambda: copy(array), repeats)


def _bytes_of(tree: Any) -> int:
    """Returns the bytes of all arrays of a tree; a typed key counts as two uint32 numbers."""
    total = 0
    for leaf in jax.tree.leaves(tree):
        if jnp.issubdtype(leaf.dtype, jax.dtypes.prng_key):
            leaf = jax.random.key_data(leaf)
        total += leaf.nbytes
    return total
