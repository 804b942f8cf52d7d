"""GPU cost of a step: kernels launched, bytes moved, and the share of the copy bandwidth reached."""

import math
import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp

from bench.gpu_cost import count_kernels
from sjdsl.bench.loop import Task
from sjdsl.bench.machine import describe_machine

COPIED = {
    "cpu": 1 << 26,
    "gpu": 1 << 28,
}  # float32 numbers of the copy: well beyond the caches (256 MiB, 1 GiB)


@dataclass(frozen=True)
class StepKernels:
    """One compiled step of `num_envs` environments.

    `kernels`: kernels launched, the body of a loop counted once. `accessed_bytes`: what XLA says its kernels read and write.
    `least_bytes`: the state and the actions read once, the next state, the rewards and the observations written once; no step
    can move less. Both for one environment. `seconds`: of one step of all environments, by round.
    """

    name: str
    num_agents: int
    observation: str
    num_envs: int
    kernels: int
    accessed_bytes: float
    least_bytes: float
    seconds: tuple[float, ...]


@dataclass(frozen=True)
class Kernels:
    """All steps measured, and the bytes a second of a large copy on the same device (read and written counted both)."""

    machine: dict[str, Any]
    copied_bytes_per_s: float
    steps: tuple[StepKernels, ...]


def measure_kernels(
    tasks: Sequence[Task], num_envs: int, repeats: int = 5, steps: int = 20
) -> Kernels:
    """Returns what one step of each task costs; `steps`: how many are timed together in a round."""
    found = tuple(_measure_step(task, num_envs, repeats, steps) for task in tasks)
    return Kernels(describe_machine(), copied_bytes_per_s(repeats), found)


def _measure_step(task: Task, num_envs: int, repeats: int, steps: int) -> StepKernels:
    states = jax.tree.map(lambda x: jnp.broadcast_to(x, (num_envs, *x.shape)), task.reset())
    keys = jax.random.split(jax.random.key(0), num_envs)
    actions = jax.random.randint(
        jax.random.key(1), (num_envs, task.num_agents), 0, task.num_actions
    )
    compiled = jax.jit(jax.vmap(task.step)).lower(states, actions, keys).compile()
    found = jax.block_until_ready(compiled(states, actions, keys))
    seconds = []
    for _ in range(repeats):
        began = time.perf_counter()
        for _ in range(steps):
            found = compiled(found[0], actions, keys)
        jax.block_until_ready(found)
        seconds.append((time.perf_counter() - began) / steps)
    least = (_bytes_of((states, actions)) + _bytes_of(found)) / num_envs
    text = compiled.as_text()
    accessed = (
        float((compiled.cost_analysis() or {}).get("bytes accessed", math.nan)) / num_envs
    )  # not a number if XLA doesn't know
    return StepKernels(
        task.name,
        task.num_agents,
        task.observation,
        num_envs,
        count_kernels(text or ""),
        accessed,
        least,
        tuple(seconds),
    )


def copied_bytes_per_s(repeats: int, numbers: int | None = None) -> float:
    """Returns the bytes a second, read and written, of a kernel that adds one to many float32 numbers: the median of the rounds."""
    size = numbers or COPIED.get(jax.devices()[0].platform, COPIED["cpu"])
    copy = jax.jit(lambda x: x + 1)
    array = jnp.zeros(size, jnp.float32)
    copy(array).block_until_ready()
    rates = []
    for _ in range(repeats):
        began = time.perf_counter()
        copy(array).block_until_ready()
        rates.append(2 * array.nbytes / (time.perf_counter() - began))
    return statistics.median(rates)


def _bytes_of(tree: Any) -> int:
    """Returns the bytes of all arrays of a tree; a typed key counts as its two words."""
    keys = jax.dtypes.prng_key
    return sum(
        (jax.random.key_data(x) if jnp.issubdtype(x.dtype, keys) else x).nbytes
        for x in jax.tree.leaves(tree)
    )
